#include "lode/delaunay/tin.h"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace lode::delaunay {
namespace {

/// A set of packed nodes that tells how many come before one.
class NodeSet {
 public:
  explicit NodeSet(std::uint32_t last) : words_(std::size_t{last / 64} + 1, 0) {}

  void add(std::uint32_t node) { words_[node / 64] |= std::uint64_t{1} << (node % 64); }
  /// Counts what has been added.
  std::uint32_t number() {
    n_before_.reserve(words_.size());
    std::uint32_t n = 0;
    for (const std::uint64_t word : words_) {
      n_before_.push_back(n);
      n += static_cast<std::uint32_t>(std::popcount(word));
    }
    return n;
  }
  [[nodiscard]] std::uint32_t number_of(std::uint32_t node) const {
    const std::uint64_t below = words_[node / 64] & ((std::uint64_t{1} << (node % 64)) - 1);
    return n_before_[node / 64] + static_cast<std::uint32_t>(std::popcount(below));
  }
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (std::size_t i = 0; i < words_.size(); ++i)
      for (std::uint64_t word = words_[i]; word != 0; word &= word - 1)
        visit(static_cast<std::uint32_t>(64 * i) +
              static_cast<std::uint32_t>(std::countr_zero(word)));
  }

 private:
  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> n_before_;
};

}  // namespace

template <typename Nodes>
Tin to_tin(const NodeMesh<Nodes>& mesh, TinLinks links) {
  Tin tin;
  std::uint32_t last = 0;
  for (const LatticeTriangle& triangle : mesh.triangles())
    last = std::max({last, triangle.corner[0], triangle.corner[1], triangle.corner[2]});
  NodeSet nodes(last);
  for (const LatticeTriangle& triangle : mesh.triangles())
    for (const std::uint32_t corner : triangle.corner) nodes.add(corner);
  tin.vertices.reserve(nodes.number());
  nodes.for_each([&](std::uint32_t node) { tin.vertices.push_back(mesh.nodes().unpack(node)); });
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
