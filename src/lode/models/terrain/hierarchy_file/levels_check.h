#pragma once

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"

namespace lode::hierarchy_file {

/// Checks the mesh of each level, as open() says, and gives triangles their twins. Corners are
/// vertices, triangles turn left, refinements are a forest by levels, no two vertices share a
/// place. `size`: the largest |height|.
[[nodiscard]] Result<void> link_levels(triangle_hierarchy::Hierarchy& hierarchy, double size,
                                       Progress& progress);

}  // namespace lode::hierarchy_file
