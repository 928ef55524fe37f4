#pragma once

#include "lode/core/vec.h"

namespace lode::delaunay {

using Point = Vec<double, 2>;

/// 1 when a, b, c turn left, -1 when they turn right, 0 when they lie on one line: exactly.
[[nodiscard]] int orientation(const Point& a, const Point& b, const Point& c);

/// The sign of (b - a) x (c - a) . (d - a): exactly.
[[nodiscard]] int orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

/// For a, b, c turning left: 1 when d lies inside their circle, -1 outside, 0 on it: exactly.
[[nodiscard]] int side_of_circle(const Point& a, const Point& b, const Point& c, const Point& d);

}  // namespace lode::delaunay
