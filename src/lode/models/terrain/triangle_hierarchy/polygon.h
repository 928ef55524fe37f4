#pragma once

#include <vector>

#include "lode/core/result.h"
#include "lode/models/terrain/triangle_hierarchy/patch.h"

namespace lode::triangle_hierarchy {

/// The Delaunay triangulation constrained by the sides of a polygon, whose corners turn left once
/// round, at least three. Fails where sides meet but at their ends, or corners turn right.
[[nodiscard]] Result<Patch> triangulate_polygon(std::vector<Place> corners);

}  // namespace lode::triangle_hierarchy
