#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "lode/delaunay/lattice.h"

namespace lode::triangle_hierarchy {

/// A rectangle of the fine lattice, with its border.
struct FineBox {
  std::int64_t x_low, y_low, x_high, y_high;
};

/// Whether all corners, which turn left, are beyond an edge of the box, or all of the box to the
/// right of one of their edges: exactly, for coordinates of at most 31 bits.
[[nodiscard]] inline bool is_apart(const std::array<delaunay::LatticePoint, 3>& corners,
                                   const FineBox& box) {
  using delaunay::LatticePoint;
  const auto all = [&](auto&& is_out) { return std::ranges::all_of(corners, is_out); };
  if (all([&](LatticePoint p) { return p.x < box.x_low; }) ||
      all([&](LatticePoint p) { return p.x > box.x_high; }) ||
      all([&](LatticePoint p) { return p.y < box.y_low; }) ||
      all([&](LatticePoint p) { return p.y > box.y_high; }))
    return true;
  for (std::size_t i = 0; i < 3; ++i) {
    const LatticePoint a = corners[i];
    const LatticePoint b = corners[(i + 1) % 3];
    const std::int64_t dx = std::int64_t{b.x} - a.x;
    const std::int64_t dy = std::int64_t{b.y} - a.y;
    // The box's corner furthest to the left of the edge.
    const std::int64_t x = dy > 0 ? box.x_low : box.x_high;
    const std::int64_t y = dx > 0 ? box.y_high : box.y_low;
    if (dx * (y - a.y) - dy * (x - a.x) < 0) return true;
  }
  return false;
}

}  // namespace lode::triangle_hierarchy
