#include "lode/models/terrain/triangle_hierarchy/point_tree.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "lode/core/expects.h"

namespace lode::triangle_hierarchy {

PointTree::PointTree(std::span<const delaunay::LatticePoint> nodes, int bits)
    : nodes_(nodes), bits_(bits), numbers_(nodes.size()) {
  LODE_EXPECTS(!nodes.empty());
  std::iota(numbers_.begin(), numbers_.end(), 0U);
  tree_.reserve(4 * nodes.size() / kMostInLeaf + 1);
  build(0, static_cast<std::uint32_t>(nodes.size()));
}

std::uint32_t PointTree::build(std::uint32_t first, std::uint32_t end) {
  const auto number = static_cast<std::uint32_t>(tree_.size());
  Node node{.box = {}, .first = first, .end = end};
  const delaunay::LatticePoint start = fine(numbers_[first]);
  node.box = {start.x, start.y, start.x, start.y};
  for (std::uint32_t i = first; i < end; ++i) {
    const delaunay::LatticePoint p = fine(numbers_[i]);
    node.box = {std::min(node.box[0], p.x), std::min(node.box[1], p.y), std::max(node.box[2], p.x),
                std::max(node.box[3], p.y)};
  }
  tree_.push_back(node);
  if (end - first <= kMostInLeaf) return number;
  const bool is_wide = node.box[2] - node.box[0] > node.box[3] - node.box[1];
  const auto place = [&](std::uint32_t i) {
    const delaunay::LatticePoint p = nodes_[i];
    return is_wide ? std::tuple(p.x, p.y) : std::tuple(p.y, p.x);
  };
  const std::uint32_t middle = first + (end - first) / 2;
  std::nth_element(numbers_.begin() + first, numbers_.begin() + middle, numbers_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  build(first, middle);
  const std::uint32_t second = build(middle, end);
  tree_[number].second_half = second;
  return number;
}

}  // namespace lode::triangle_hierarchy
