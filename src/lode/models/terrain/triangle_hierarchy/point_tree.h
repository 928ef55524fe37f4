#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/terrain/triangle_hierarchy/triangle_box.h"

namespace lode::triangle_hierarchy {

/// Finds points near triangles, however unevenly they lie: halves by columns or rows, again and
/// again (J. Bentley, "Multidimensional binary search trees used for associative searching", 1975),
/// each with its bounds.
class PointTree {
 public:
  /// Nodes of a lattice, which outlive this, at least one; found by fine ones, 2^bits times as
  /// many. O(n log n), about 6 bytes a point.
  PointTree(std::span<const delaunay::LatticePoint> nodes, int bits);

  /// Calls visit(number, fine node) for points in the closed triangle, whose fine corners turn
  /// left, or not farther than `reach` from it in columns and rows, and for some beside; always in
  /// the same order. O(those + sqrt(n)) usually.
  template <typename Visit>
  void visit_near(const std::array<delaunay::LatticePoint, 3>& corners, const Visit& visit,
                  std::int64_t reach = 0) const;

 private:
  static constexpr std::size_t kMostInLeaf = 8;

  /// Of the numbers from first to end, in a box; its halves, if any, follow: the first one at once.
  struct Node {
    std::array<std::int32_t, 4> box;  ///< Fine: x from, y from, x to, y to.
    std::uint32_t first = 0;
    std::uint32_t end = 0;
    std::uint32_t second_half = 0;  ///< 0: there are none.
  };

  std::uint32_t build(std::uint32_t first, std::uint32_t end);
  [[nodiscard]] delaunay::LatticePoint fine(std::uint32_t number) const {
    return {nodes_[number].x << bits_, nodes_[number].y << bits_};
  }

  std::span<const delaunay::LatticePoint> nodes_;
  int bits_;
  std::vector<std::uint32_t> numbers_;
  std::vector<Node> tree_;
};

template <typename Visit>
void PointTree::visit_near(const std::array<delaunay::LatticePoint, 3>& corners, const Visit& visit,
                           std::int64_t reach) const {
  // Halves are at most 32 deep, and each leaves one other waiting.
  std::array<std::uint32_t, 64> waiting{};
  std::size_t n_waiting = 1;
  while (n_waiting > 0) {
    const std::uint32_t at = waiting[--n_waiting];
    const Node& node = tree_[at];
    if (is_apart(corners, {node.box[0] - reach, node.box[1] - reach, node.box[2] + reach,
                           node.box[3] + reach}))
      continue;
    if (node.second_half == 0) {
      for (std::uint32_t i = node.first; i < node.end; ++i) visit(numbers_[i], fine(numbers_[i]));
      continue;
    }
    waiting[n_waiting++] = node.second_half;
    waiting[n_waiting++] = at + 1;
  }
}

}  // namespace lode::triangle_hierarchy
