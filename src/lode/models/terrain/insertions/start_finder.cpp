#include "lode/models/terrain/insertions/start_finder.h"

#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode::insertions {

StartFinder::StartFinder(const History& history,
                         std::span<const std::array<std::uint32_t, 3>> triangles) {
  delaunay::Tin tin;
  tin.triangles.assign(triangles.begin(), triangles.end());
  place_vertices(history, tin);
  tin.twins = delaunay::find_twins(tin.triangles);
  mesh_ = std::make_unique<const Mesh>(std::move(tin));
}

std::uint64_t StartFinder::n_bytes() const {
  // The locator takes about 16 bytes a triangle.
  const delaunay::Tin& tin = mesh_->tin;
  return tin.triangles.size() * (sizeof(tin.triangles[0]) + sizeof(tin.twins[0]) + 16) +
         tin.vertices.size() * (sizeof(tin.vertices[0]) + sizeof(double));
}

}  // namespace lode::insertions
