#include "lode/delaunay/tin.h"

#include <algorithm>
#include <cstddef>

#include "lode/delaunay/numbered_nodes.h"

namespace lode::delaunay {

template <typename Nodes>
Tin to_tin(const NodeMesh<Nodes>& mesh, TinLinks links) {
  Tin tin;
  std::uint32_t last = 0;
  for (const LatticeTriangle& triangle : mesh.triangles())
    last = std::max({last, triangle.corner[0], triangle.corner[1], triangle.corner[2]});
  NumberedNodes nodes(last);
  for (const LatticeTriangle& triangle : mesh.triangles())
    for (const std::uint32_t corner : triangle.corner) nodes.add(corner);
  tin.vertices.reserve(nodes.number());
  for (std::size_t word = 0; word < nodes.n_words(); ++word)
    nodes.for_each_in(word, [&](std::uint32_t node, std::uint32_t /*number*/) {
      tin.vertices.push_back(mesh.nodes().unpack(node));
    });
  tin.triangles.reserve(mesh.triangles().size());
  for (const LatticeTriangle& triangle : mesh.triangles()) {
    auto& made = tin.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) made[i] = nodes.number_of(triangle.corner[i]);
  }
  if (links == TinLinks::left_out) return tin;
  tin.twins.reserve(mesh.triangles().size());
  tin.errors.reserve(mesh.triangles().size());
  for (const LatticeTriangle& triangle : mesh.triangles()) {
    tin.twins.push_back(triangle.twin);
    tin.errors.push_back(triangle.error);
  }
  return tin;
}
template Tin to_tin(const LatticeMesh&, TinLinks);
template Tin to_tin(const PointMesh&, TinLinks);

}  // namespace lode::delaunay
