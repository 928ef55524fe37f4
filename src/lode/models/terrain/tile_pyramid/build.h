#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/tile_pyramid/border_chain.h"
#include "lode/models/terrain/tile_pyramid/height_rows.h"
#include "lode/models/terrain/tile_pyramid/tile_mesh.h"
#include "lode/models/terrain/tile_pyramid/tile_scheme.h"

namespace lode::tile_pyramid {

/// What clients of quantized-mesh take the error of a tile of level 0 to be, in metres, and half as
/// much with each level: a quarter of the distance of samples, were a tile 65 of them wide at the
/// equator.
inline constexpr double kLevelZeroError = 77067.33987351177;

/// Of a pyramid whose finest level nobody asked for.
inline constexpr std::uint64_t kMostTiles = std::uint64_t{1} << 22;

struct TileBuildOptions {
  double max_error = 1;            ///< > 0: of the finest level; see level_errors().
  std::optional<int> max_level{};  ///< Without: finest_level() of the raster.
  double fill = 0;                 ///< Height where there are no samples; at most kMostHeight.
  Threads threads{};
};

/// The first level whose tiles are at most 256 samples wide and high.
[[nodiscard]] int finest_level(const ExtendedRaster& raster);

/// Fails, naming their number, where there are more than kMostTiles.
[[nodiscard]] Result<void> check_number_of_tiles(std::span<const TileRange> ranges);

/// By level: max_error for the last, twice as much for each before, but nowhere more than what
/// clients take it to be.
[[nodiscard]] std::vector<double> level_errors(double max_error, int last);

struct LevelReport {
  TileRange range;
  LevelForm form;
  double error = 0;            ///< No sample is farther from its tile's triangle; measured.
  std::uint64_t n_beyond = 0;  ///< Tiles whose lattice does not allow max_error.
  std::uint64_t n_triangles = 0;
  std::uint64_t n_vertices = 0;  ///< Those on sides count in each tile.
};

struct FinishedTile {
  TileId id;
  const TileMesh& mesh;
  const LevelForm& form;
  double error = 0;  ///< As LevelReport::error.
};

/// Takes tiles, from several threads at once.
using TileSink = std::function<Result<void>(const FinishedTile&)>;

/// A pyramid of tiles of a raster in degrees; docs/models/tile_pyramid.md. Finest tiles are refined
/// by their samples, coarser ones by the vertices of their four, and both by nodes that the globe's
/// curvature needs, see n_globe_cells(); then all samples are held against
/// the triangles, as they will be decoded, and the worst ones inserted until none is beyond the
/// level's tolerance. Reads the raster as often as there are levels, and a few times more. Memory:
/// two rows of tiles of each level, 512 rows of samples, and what is on borders. Tiles are the same
/// for any number of threads. Returns what became of each level; fails as RowStrip and `sink` do,
/// without max_level as check_number_of_tiles() does, and when cancelled.
[[nodiscard]] Result<std::vector<LevelReport>> build_tiles(HeightRows& rows,
                                                           const TileBuildOptions& options,
                                                           const TileSink& sink,
                                                           Progress& progress);

}  // namespace lode::tile_pyramid
