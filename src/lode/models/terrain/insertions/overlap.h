#pragma once

#include <array>

#include "lode/delaunay/lattice.h"

namespace lode::insertions {

using delaunay::LatticeCorners;

/// Whether an edge of `a` has all of `b` to its right, or on it.
[[nodiscard]] inline bool is_separated_by_edges(const LatticeCorners& a, const LatticeCorners& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto is_left = [&](delaunay::LatticePoint p) {
      return delaunay::doubled_area(a[i], a[(i + 1) % 3], p) > 0;
    };
    if (!is_left(b[0]) && !is_left(b[1]) && !is_left(b[2])) return true;
  }
  return false;
}

/// Whether the interiors of two triangles, which turn left, meet: exactly, as convex sets that do
/// not are separated by an edge of one of them.
[[nodiscard]] inline bool do_interiors_meet(const LatticeCorners& a, const LatticeCorners& b) {
  return !is_separated_by_edges(a, b) && !is_separated_by_edges(b, a);
}

/// Whether the closed triangle, which turns left, holds p.
[[nodiscard]] inline bool holds(const LatticeCorners& triangle, delaunay::LatticePoint p) {
  for (std::size_t i = 0; i < 3; ++i)
    if (delaunay::doubled_area(triangle[i], triangle[(i + 1) % 3], p) < 0) return false;
  return true;
}

}  // namespace lode::insertions
