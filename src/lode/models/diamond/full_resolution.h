#pragma once

#include "lode/core/progress.h"
#include "lode/core/surface.h"
#include "lode/mappers/lattice_frame.h"
#include "lode/models/diamond/extract.h"
#include "lode/models/diamond/selection.h"

namespace lode::diamond {

/// What a full-resolution extraction found besides the surface.
struct FullResolutionReport {
  double largest_step = 0;  ///< Largest difference of values along a crossed edge.
  double largest_snap = 0;  ///< The same over vertices that the margin moved.
  std::uint64_t n_bricks_read = 0;
  double sign_seconds = 0;   ///< Ranges of bricks, sign bits and counts: their share of the whole.
  double write_seconds = 0;  ///< Room, vertices and triangles.
};

/// Tolerance 0 on a volume without holes: the surface in all finest simplices, by rows of cells
/// instead of a traversal (sign bits, counts, sums, write), slab by slab. The same
/// vertices and triangles as the traversal's but for their order, which depends on nothing but
/// the model: by row of cells. Appends to `surface` or replaces it, as the query says; after an
/// error it is empty.
[[nodiscard]] Result<FullResolutionReport> extract_full_resolution(const Selection<3>& selection,
                                                                   const LatticeFrame& frame,
                                                                   const IsosurfaceQuery& query,
                                                                   Surface& surface,
                                                                   Progress& progress);

}  // namespace lode::diamond
