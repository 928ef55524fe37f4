#include "lode/api/terrain_tiles.h"

#include <cmath>
#include <new>
#include <utility>

#include "lode/api/tile_folder.h"
#include "lode/api/tile_raster.h"
#include "lode/core/expects.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/staged_file.h"
#include "lode/core/stopwatch.h"
#include "lode/models/terrain/tile_pyramid/build.h"
#include "lode/models/terrain/tile_pyramid/extended_raster.h"

namespace lode {

using tile_pyramid::FinishedTile;

namespace {

Result<std::optional<io::ResamplingError>> resampling_of(const std::string& path,
                                                         const io::HeightReadOptions& reading,
                                                         const TileRaster& raster, Threads threads,
                                                         Progress& progress) {
  if (!reading.to_degrees || !raster.is_in_memory) return std::optional<io::ResamplingError>();
  LODE_TRY(const auto error, io::measure_resampling(path, reading, threads, progress));
  return std::optional(error);
}

}  // namespace

Result<TerrainTileReport> write_terrain_tiles(const std::string& path,
                                              const io::HeightReadOptions& reading,
                                              const TerrainTileOptions& options,
                                              const std::string& folder, Progress& progress) try {
  static_assert(kMostTileHeight == tile_pyramid::kMostHeight);
  LODE_EXPECTS(options.max_error > 0 && std::abs(options.fill) <= kMostTileHeight);
  TerrainTileReport report;
  const Stopwatch watch;
  LODE_TRY(StagedFolder staged, StagedFolder::create(folder));
  LODE_TRY(const TileRaster raster, open_tile_raster(path, reading, options.most_bytes, progress));
  auto place = tile_pyramid::ExtendedRaster::of(raster.rows->frame(), options.fill);
  if (!place) return fail("{}: {}", path, place.error().message);
  LODE_TRY(report.resampling, resampling_of(path, reading, raster, options.threads, progress));
  report.read_seconds = watch.seconds();

  TileFolder tiles(staged.folder());
  LODE_TRY(const auto levels,
           tile_pyramid::build_tiles(
               *raster.rows,
               {.max_error = options.max_error,
                .max_level = options.max_level,
                .fill = options.fill,
                .threads = options.threads},
               [&](const FinishedTile& tile) { return tiles.add(tile); }, progress));
  const HeightFrame& frame = raster.rows->frame();
  if (raster.rows->n_missing() ==
      static_cast<std::uint64_t>(std::int64_t{frame.n_columns} * frame.n_rows))
    return fail("{}: expected samples with heights, got none of {} x {}", path, frame.n_columns,
                frame.n_rows);
  LODE_CHECK(tiles.write_layer(levels, place->box()));
  LODE_CHECK(staged.commit(progress));
  for (const auto& level : levels)
    report.levels.push_back({.n_tiles = level.range.n_tiles(),
                             .n_triangles = level.n_triangles,
                             .n_vertices = level.n_vertices,
                             .n_bytes = tiles.n_bytes(level.range.level),
                             .max_error = level.form.max_error,
                             .error = level.error,
                             .height_step = level.form.height_step,
                             .n_beyond = level.n_beyond});
  report.frame = raster.rows->frame();
  report.type = raster.type;
  report.n_missing = raster.rows->n_missing();
  report.vertical = raster.vertical;
  report.notes = raster.notes;
  report.build_seconds = watch.seconds() - report.read_seconds;
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("write tiles", folder);
}

}  // namespace lode
