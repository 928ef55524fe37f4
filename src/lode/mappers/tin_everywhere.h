#pragma once

#include <cstdint>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// Raises what a TIN's triangles say of their errors, until it holds everywhere and not at samples
/// alone: against the surface of all samples, linear on the two triangles of each cell that
/// delaunay::to_full_tin() makes. What both differ by is linear on each part of a triangle that
/// lies in one of the other surface, so it is largest at a corner of such parts: at a sample, which
/// the errors are of, at the triangle's own corners, or where an edge of one crosses an edge of the
/// other. `scale`: the TIN's nodes are so many to a cell, a power of two; its vertices are samples,
/// or lie on a column or row between two, with the height that is linear there. The TIN has heights
/// and errors, and lies in cells with four heights. Rounded up. O(columns and rows that edges
/// cross). Fails when cancelled.
[[nodiscard]] Result<void> raise_errors_everywhere(const HeightGrid& grid, std::int32_t scale,
                                                   Threads threads, Progress& progress,
                                                   delaunay::Tin& tin);

}  // namespace lode
