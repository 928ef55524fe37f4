#pragma once

#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/mappers/self_intersections.h"
#include "lode/mappers/surface_match.h"
#include "lode/mappers/surface_topology.h"

namespace lode {

/// Whether a surface can be looked at all: all coordinates finite, all indices in range, and not
/// both triangles and lines. Every other check expects this to hold.
[[nodiscard]] Result<void> check_well_formed(const Surface& surface);

}  // namespace lode
