#pragma once

#include <cstdint>

#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/delaunay_pyramid/history.h"

namespace lode::delaunay_pyramid {

/// Inserts samples of a grid, always the worst of all, until every one is within max_error (finite,
/// >= 0), and keeps the history: the Delaunay pyramid of L. De Floriani, "A pyramidal data
/// structure for triangle-based surface description", IEEE CG&A 9 (2), 1989, with a level at each
/// insertion. O(n log n) usually, one thread. Fails as select_samples() does.
[[nodiscard]] Result<History> build_history(const HeightGrid& grid, double max_error,
                                            Progress& progress);

}  // namespace lode::delaunay_pyramid
