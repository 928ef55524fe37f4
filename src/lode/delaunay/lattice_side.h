#pragma once

#include <cmath>

#include "lode/delaunay/lattice.h"
#include "lode/delaunay/predicates.h"

namespace lode::delaunay {

[[nodiscard]] inline Point to_point(LatticePoint p) {
  return {{static_cast<double>(p.x), static_cast<double>(p.y)}};
}

/// orientation(a, b, c), exactly, without a call where doubles are sure (J. R. Shewchuk, "Adaptive
/// precision floating-point arithmetic and fast robust geometric predicates", 1997, section 4.3).
[[nodiscard]] inline int side_of(const Point& a, const Point& b, const Point& c) {
  constexpr double kSure = (3 + 16 * 0x1p-53) * 0x1p-53;
  const double left = (a[0] - c[0]) * (b[1] - c[1]);
  const double right = (a[1] - c[1]) * (b[0] - c[0]);
  const double determinant = left - right;
  const double bound = kSure * (std::abs(left) + std::abs(right));
  if (determinant > bound) return 1;
  if (-determinant > bound) return -1;
  return orientation(a, b, c);
}

/// On which side of the line from a to b a place is: 1 on the left, 0 on it, exactly.
[[nodiscard]] inline int side_of(LatticePoint a, LatticePoint b, const Point& p) {
  return side_of(to_point(a), to_point(b), p);
}

}  // namespace lode::delaunay
