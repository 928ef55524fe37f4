#pragma once

#include <span>

#include "lode/core/vec.h"
#include "lode/mappers/iso_part.h"

namespace lode {

/// Where vertices are in the world, relative to the frame's surface_origin: each is
/// frame.position(point.lattice_position()), rounded. `out` has room for as many.
void place_points(std::span<const EdgePoint> points, const LatticeFrame& frame, Vec3f* out);

}  // namespace lode
