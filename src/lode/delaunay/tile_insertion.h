#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/uninitialized_array.h"
#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/tile_layout.h"
#include "lode/delaunay/tin.h"

namespace lode::delaunay {

/// The triangles of a tile.
struct TilePiece {
  /// Nodes of the raster, packed.
  UninitializedArray<std::array<std::uint32_t, 3>> corners;
  /// As LatticeTriangle::twin, of this piece alone; where links are kept.
  UninitializedArray<std::array<std::uint32_t, 3>> twins;
  UninitializedArray<float> errors;  ///< Where links are kept.
};

/// Tiles side by side, which have the same vertices where they meet.
struct SeamedTiles {
  TileLayout layout;
  std::vector<TilePiece> pieces{};  ///< By tile.
  GreedyReport report{};
  std::uint64_t n_samples = 0;   ///< Of the domain (grid_domain.h).
  std::uint64_t n_left_out = 0;  ///< Valid samples that are not in it.
};

struct TileOptions {
  double max_error = 0;   ///< >= 0: no sample errs by more in the end.
  std::int32_t side = 0;  ///< Of tiles, about, in steps; 0: as choose_tile_side() says.
  TinLinks links = TinLinks::left_out;
  Threads threads{};
};

/// The Delaunay selector in tiles: the raster is cut along columns and rows. First samples on these
/// seams are chosen, by what lies on them alone (LineSplitter). Then each tile is triangulated with
/// them and refined on its own, in levels; nothing more is inserted on its sides. So edges inside
/// of tiles are Delaunay, those on seams constrain them. `lower` and `upper`: of the heights.
/// Memory beside what comes out: a tile's mesh for each thread. The same for any number of them.
/// Fails as find_domain() does, and when cancelled.
template <typename T>
[[nodiscard]] Result<SeamedTiles> insert_in_tiles(const HeightGrid& grid, double lower,
                                                  double upper, const TileOptions& options,
                                                  Progress& progress);

/// Of all tiles, one after the other, with links where the pieces have them. Empties the pieces.
[[nodiscard]] Tin to_tin(SeamedTiles& tiles, Threads threads);

}  // namespace lode::delaunay
