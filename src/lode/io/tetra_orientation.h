#pragma once

#include <array>

#include "lode/core/vec.h"

namespace lode::io {

/// The sign of (b - a) x (c - a) . (d - a): 1, 0 or -1, exactly unless products underflow. In
/// double alone cells of no volume come out with either sign.
[[nodiscard]] int orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

}  // namespace lode::io
