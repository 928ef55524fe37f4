#pragma once

#include <memory>
#include <vector>

#include "lode/api/compared_terrain.h"

namespace lode {

/// Hierarchies of triangulations, one level for each tolerance: the adaptive one, and the
/// Delaunay one.
[[nodiscard]] std::vector<std::unique_ptr<TerrainCandidate>> hierarchy_candidates();

}  // namespace lode
