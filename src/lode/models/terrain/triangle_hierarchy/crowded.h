#pragma once

#include <cstdint>
#include <vector>

#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"
#include "lode/models/terrain/triangle_hierarchy/reference_surface.h"

namespace lode::triangle_hierarchy {

/// Hierarchy::crowded of a hierarchy over points: how far to the right of a triangle's edges, or
/// out of its bounds, what refines it and what refines that has vertices, and whether a sample is
/// out of it and no farther. Ascending. O(levels triangles), and a query for each triangle that has
/// any.
[[nodiscard]] std::vector<std::uint32_t> find_crowded(const Hierarchy& hierarchy,
                                                      const ReferenceSurface& surface);

}  // namespace lode::triangle_hierarchy
