#pragma once

#include <array>
#include <optional>

namespace lode {

/// A corner of one tetrahedron as another sees it.
struct OverlapCorner {
  std::array<double, 4> weights{};  ///< Of the other's corners: 0 or more inside.
  double difference = 0;            ///< Of functions that are linear, each on one of them.
};

struct CellOverlap {
  double largest = 0;              ///< |difference|: it is at a corner of what they have in common.
  std::array<double, 4> centre{};  ///< Weights of a point in the middle of that.
};

/// What both have in common: one is cut at the planes of the other's faces, one after the other, in
/// tetrahedra. None where they do not meet.
[[nodiscard]] std::optional<CellOverlap> find_overlap(const std::array<OverlapCorner, 4>& cell);

}  // namespace lode
