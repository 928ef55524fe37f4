#pragma once

// Which triangles a search for places and segments follows.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "lode/delaunay/lattice_side.h"
#include "lode/delaunay/predicates.h"
#include "lode/models/terrain/insertions/box_tree.h"
#include "lode/models/terrain/insertions/overlap.h"

namespace lode::insertions {

/// Round two places.
[[nodiscard]] inline LatticeBox box_round(const delaunay::Point& a, const delaunay::Point& b) {
  static constexpr double kEdge = 0x1p30;
  const auto clamped = [](double x) {
    return static_cast<std::int32_t>(std::clamp(x, -kEdge, kEdge));
  };
  return {{clamped(std::floor(std::min(a[0], b[0]))), clamped(std::floor(std::min(a[1], b[1])))},
          {clamped(std::ceil(std::max(a[0], b[0]))), clamped(std::ceil(std::max(a[1], b[1])))}};
}

/// Whether the closed triangle, which turns left, holds a place: exactly.
[[nodiscard]] inline bool holds_place(const LatticeCorners& triangle, const delaunay::Point& p) {
  for (std::size_t i = 0; i < 3; ++i)
    if (delaunay::side_of(triangle[i], triangle[(i + 1) % 3], p) < 0) return false;
  return true;
}

/// Whether all corners are to one side of the line through two places: exactly.
[[nodiscard]] inline bool is_beside_line(const LatticeCorners& triangle, const delaunay::Point& a,
                                         const delaunay::Point& b) {
  int n_left = 0;
  int n_right = 0;
  for (const delaunay::LatticePoint& p : triangle) {
    const int side = delaunay::side_of(a, b, delaunay::to_point(p));
    n_left += side > 0 ? 1 : 0;
    n_right += side < 0 ? 1 : 0;
  }
  return n_left == 3 || n_right == 3;
}

}  // namespace lode::insertions
