#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lode/delaunay/lattice.h"

namespace lode::insertions {

/// A rectangle of nodes, with its border.
struct LatticeBox {
  delaunay::LatticePoint lower{std::numeric_limits<std::int32_t>::max(),
                               std::numeric_limits<std::int32_t>::max()};
  delaunay::LatticePoint upper{std::numeric_limits<std::int32_t>::min(),
                               std::numeric_limits<std::int32_t>::min()};

  void add(delaunay::LatticePoint p) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y)};
  }
  void add(const LatticeBox& box) {
    add(box.lower);
    add(box.upper);
  }
  /// Whether all of another one is in it.
  [[nodiscard]] bool has(const LatticeBox& other) const {
    return lower.x <= other.lower.x && other.upper.x <= upper.x && lower.y <= other.lower.y &&
           other.upper.y <= upper.y;
  }
  [[nodiscard]] bool meets(const LatticeBox& other) const {
    return lower.x <= other.upper.x && other.lower.x <= upper.x && lower.y <= other.upper.y &&
           other.lower.y <= upper.y;
  }
};

[[nodiscard]] inline LatticeBox box_of(const delaunay::LatticeCorners& corners) {
  LatticeBox box;
  for (const delaunay::LatticePoint& p : corners) box.add(p);
  return box;
}

/// Where a node is along a curve that visits near ones one after the other: of squares in squares
/// (G. M. Morton, 1966).
[[nodiscard]] inline std::uint64_t place_along_z(delaunay::LatticePoint p) {
  const auto spread = [](std::int32_t number) {
    std::uint64_t bits = static_cast<std::uint32_t>(number);
    bits = (bits | bits << 16) & 0x0000FFFF0000FFFFU;
    bits = (bits | bits << 8) & 0x00FF00FF00FF00FFU;
    bits = (bits | bits << 4) & 0x0F0F0F0F0F0F0F0FU;
    bits = (bits | bits << 2) & 0x3333333333333333U;
    return (bits | bits << 1) & 0x5555555555555555U;
  };
  return spread(p.x) | spread(p.y) << 1;
}

/// Boxes in an order in which neighbours are near each other, and boxes round eight, sixty-four and
/// so on of them.
class BoxTree {
 public:
  BoxTree() = default;
  explicit BoxTree(std::vector<LatticeBox> boxes) {
    if (boxes.empty()) return;
    levels_.push_back(std::move(boxes));
    while (levels_.back().size() > 1) {
      const std::vector<LatticeBox>& below = levels_.back();
      std::vector<LatticeBox> level((below.size() + kFan - 1) / kFan);
      for (std::size_t i = 0; i < below.size(); ++i) level[i / kFan].add(below[i]);
      levels_.push_back(std::move(level));
    }
  }

  /// visit(i) for each box that meets(box), which has to be so of a box round one that it is so of;
  /// from the first on, until visit() is false.
  template <typename Meets, typename Visit>
  void for_each(const Meets& meets, const Visit& visit) const {
    if (!levels_.empty()) go_down(levels_.size() - 1, 0, meets, visit);
  }

 private:
  static constexpr std::size_t kFan = 8;

  template <typename Meets, typename Visit>
  bool go_down(std::size_t level, std::size_t i, const Meets& meets, const Visit& visit) const {
    if (!meets(levels_[level][i])) return true;
    if (level == 0) return visit(static_cast<std::uint32_t>(i));
    const std::size_t end = std::min((i + 1) * kFan, levels_[level - 1].size());
    for (std::size_t k = i * kFan; k < end; ++k)
      if (!go_down(level - 1, k, meets, visit)) return false;
    return true;
  }

  std::vector<std::vector<LatticeBox>> levels_;  ///< The boxes first.
};

}  // namespace lode::insertions
