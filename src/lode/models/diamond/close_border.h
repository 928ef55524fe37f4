#pragma once

#include <cstdint>

#include "lode/core/parallel.h"
#include "lode/core/regular_grid.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"

namespace lode::diamond {

struct CapReport {
  std::uint64_t n_cells = 0;  ///< Triangles (lines) that were added.
  std::uint64_t n_open = 0;   ///< Edges (end points) at holes, where the surface stays open.
};

/// Makes an isosurface the whole boundary of {F' >= isovalue} in the domain: adds caps in the
/// border planes of the lattice (for contour lines: lines along its border). Caps share the
/// surface's vertices; the only new ones are corners of the domain and, in oblique frames, samples
/// on its edges hardly beside vertices. Each is a constrained Delaunay triangulation of what the
/// surface's edges in the plane and the box's edges enclose, so nothing overlaps.
/// `is_first_sample_inside` says whether F >= isovalue at sample (0, 0, 0), which decides where the
/// surface does not meet the border: of an empty surface it becomes the border itself, or nothing;
/// `has_normals`: that then gets normals.
/// Expects a surface of one isovalue with triangles counter-clockwise from lower values, as
/// extracted, of a field without holes at the border. Fails, and leaves it as it was, where its
/// edges in a border plane do not enclose anything, or lie along an edge of the domain.
[[nodiscard]] Result<CapReport> close_border(const RegularGrid& grid, bool is_first_sample_inside,
                                             bool has_normals, Threads threads, Surface& surface);

}  // namespace lode::diamond
