#pragma once

#include <memory>

#include "lode/api/compared_terrain.h"

namespace lode {

/// Bisected right triangles.
[[nodiscard]] std::unique_ptr<TerrainCandidate> bisection_candidate();

}  // namespace lode
