#pragma once

#include <memory>
#include <vector>

#include "lode/api/compared_terrain.h"

namespace lode {

/// The encodings of one Delaunay pyramid, whose levels are the tolerances: the hypertriangulation,
/// the lists of triangles without and with links, and the complete structure. They share one
/// history, which the first to be prepared builds. Links that would take more than `memory_limit`
/// are refused.
[[nodiscard]] std::vector<std::unique_ptr<TerrainCandidate>> pyramid_candidates(
    std::uint64_t memory_limit);

}  // namespace lode
