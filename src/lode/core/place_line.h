#pragma once

#include <vector>

#include "lode/core/vec.h"

namespace lode {

/// A line through places x, y, with heights, or NaN where it has none.
using PlaceLine = std::vector<Vec3d>;

}  // namespace lode
