#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/result.h"
#include "lode/delaunay/grid_cells.h"
#include "lode/delaunay/lattice.h"

namespace lode::delaunay {

/// The part of the plane that heights on a lattice define a surface over: the union of the cells
/// whose four corners are valid.
struct GridDomain {
  /// Corners of the outline, packed, turning left (x to the right, y up), constrained Delaunay: the
  /// coarsest triangulation that has the whole outline.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::uint64_t n_cells = 0;
  std::uint64_t n_samples = 0;   ///< Corners of those cells.
  std::uint64_t n_left_out = 0;  ///< Valid samples that are corners of none.
};

/// O(cells), and O(n log n) for n corners of the outline. `side_rows`, from small to large: where
/// the outline has vertices beside its corners, on the first and the last column. Fails where there
/// are no such cells, and where nodes do not fit in 32 bits.
[[nodiscard]] Result<GridDomain> find_domain(const HeightGrid& grid,
                                             std::span<const std::int32_t> side_rows = {});

/// The coarsest triangulation that has the outline of those cells, as GridDomain::triangles; at
/// least one is inside. `side_rows`: as of find_domain(). O(n log n) for n corners.
[[nodiscard]] Result<std::vector<std::array<std::uint32_t, 3>>> triangulate_cells(
    const GridCells& cells, const LatticePacking& packing,
    std::span<const std::int32_t> side_rows = {});

/// What find_domain() fails for: a lattice without area, or whose nodes do not fit in 32 bits; and
/// a grid, which has those cells, without any.
[[nodiscard]] Result<void> check_lattice(const HeightGrid& grid);
[[nodiscard]] Result<void> check_cells(const GridCells& cells, const HeightGrid& grid);

/// Fails beyond 1e30, as slopes and errors of such heights come near to where float32 ends.
[[nodiscard]] Result<void> check_heights(const HeightRange& range);

}  // namespace lode::delaunay
