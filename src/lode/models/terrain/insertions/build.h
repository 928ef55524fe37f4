#pragma once

#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/insertions/history.h"
#include "lode/models/terrain/insertions/point_ground.h"

namespace lode::insertions {

/// Inserts samples of a grid, always the worst of all, until every one is within max_error (finite,
/// >= 0), and keeps the history: that of a Delaunay pyramid (L. De Floriani, "A pyramidal data
/// structure for triangle-based surface description", IEEE CG&A 9 (2), 1989), with a level at each
/// insertion, or of a ternary triangulation (L. De Floriani, B. Falcidieno, G. Nagy, C. Pienovi, "A
/// hierarchical structure for surface approximation", Computers and Graphics 8 (2), 1984). O(n log
/// n) usually, one thread. Fails as select_samples() does.
[[nodiscard]] Result<History> build_history(const HeightGrid& grid, double max_error, Model model,
                                            Progress& progress);

/// The same of scattered points, perhaps with lines. Fails as select_points() does.
[[nodiscard]] Result<History> build_history(const PointGround& ground, double max_error,
                                            Model model, Progress& progress);

}  // namespace lode::insertions
