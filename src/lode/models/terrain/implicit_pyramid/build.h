#pragma once

#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/insertions/history.h"
#include "lode/models/terrain/insertions/point_ground.h"

namespace lode::implicit_pyramid {

/// The implicit Delaunay pyramid (M. de Berg, K. Dobrindt, "On levels of detail in terrains", 11th
/// ACM Symposium on Computational Geometry, 1995; paper 004, section 8) of all samples of a grid:
/// thin() takes them away level by level, and inserting them again, from the coarsest level on,
/// makes the triangles of all levels, whose errors are measured. Insertions of a level do not
/// depend on each other but for cells of four, whose diagonals may differ. O(n log n), one thread.
/// Fails as select_samples() does.
[[nodiscard]] Result<insertions::History> build(const HeightGrid& grid, Progress& progress);

/// The same of scattered points, perhaps with lines. Points on lines inside are inserted before all
/// others, in a level of their own. Fails as select_points() does.
[[nodiscard]] Result<insertions::History> build(const insertions::PointGround& ground,
                                                Progress& progress);

}  // namespace lode::implicit_pyramid
