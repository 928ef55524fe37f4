#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/terrain/tile_pyramid/extended_raster.h"
#include "lode/models/terrain/tile_pyramid/tile_mesh.h"
#include "lode/models/terrain/tile_pyramid/tile_scheme.h"

namespace lode::tile_pyramid {

/// The sample in a triangle that errs most, the first of several in rows.
struct WorstInTriangle {
  double error = -1;  ///< Vertical, from the triangle's plane; < 0: no sample is in it.
  double height = 0;  ///< Of the sample.
  std::int64_t column = 0;
  std::int64_t row = 0;
  int turn = 0;
};

/// Holds samples in some rows of a strip against some triangles of a tile; those on edges against
/// both. Samples are where the raster has them, vertices where the tile's lattice has. `worst`: by
/// triangle; of other rows what these had. Rounding: below 2^-48 of the heights.
void measure(const TileMesh& mesh, const TileId& tile, const ExtendedRaster& raster,
             const RowStrip& strip, IndexRange rows, std::span<const std::uint32_t> triangles,
             std::span<WorstInTriangle> worst);

/// The node next to a sample, which may be outside of the tile.
[[nodiscard]] LatticePoint node_of(const TileId& tile, const ExtendedRaster& raster,
                                   std::int64_t column, std::int64_t row, int turn);

}  // namespace lode::tile_pyramid
