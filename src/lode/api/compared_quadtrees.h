#pragma once

#include <memory>
#include <vector>

#include "lode/api/compared_terrain.h"

namespace lode {

/// The surface quadtree, without and with its continuity forced, the quaternary triangulation, and
/// the restricted quadtree.
[[nodiscard]] std::vector<std::unique_ptr<TerrainCandidate>> quadtree_candidates();

}  // namespace lode
