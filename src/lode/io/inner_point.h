#pragma once

#include <span>

#include "lode/core/vec.h"

namespace lode::io {

/// The points x with normal . x <= offset; the normal is of length 1.
struct HalfSpace {
  Vec3d normal;
  double offset = 0;
};

/// Where the least distance to the planes of half-spaces is largest, counted negative outside of
/// them: inside of all of them, if such a point is there. The half-spaces are of a scale of 1: the
/// point is looked for where coordinates are within 1 of 0. Steps of the simplex method, each in
/// time linear in their number; no more than 1000, after which the best point so far is given.
[[nodiscard]] Vec3d innermost_point(std::span<const HalfSpace> half_spaces);

}  // namespace lode::io
