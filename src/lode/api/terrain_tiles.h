#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/height_reader.h"
#include "lode/io/resampling_error.h"

namespace lode {

/// Of TerrainTileOptions::max_level, at most.
inline constexpr int kMostTileLevels = 22;

/// Metres from the ellipsoid, of heights and TerrainTileOptions::fill, at most.
inline constexpr double kMostTileHeight = 1e7;

struct TerrainTileOptions {
  double max_error = 1;  ///< > 0, metres: of the finest level; of coarser ones see levels.
  std::optional<int>
      max_level{};  ///< Without: tiles of the finest have at most 256 samples a side.
  double fill = 0;  ///< Metres: of what the raster does not cover.
  std::uint64_t most_bytes = std::uint64_t{512} << 20;  ///< See open_tile_raster().
  Threads threads{};
};

struct TerrainTileReport {
  struct Level {
    std::uint64_t n_tiles = 0;
    std::uint64_t n_triangles = 0;
    std::uint64_t n_vertices = 0;
    std::uint64_t n_bytes = 0;
    double max_error = 0;  ///< Asked for.
    double error = 0;      ///< Of the tiles as they are decoded, at all samples: measured.
    double height_step = 0;
    std::uint64_t n_beyond = 0;  ///< Tiles that are not within max_error: their lattice forbids it.
  };
  std::vector<Level> levels;
  HeightFrame frame;
  std::string type;  ///< Of the raster, and so the next two.
  std::uint64_t n_missing = 0;
  io::VerticalOutcome vertical{};
  std::vector<std::string> notes;  ///< Of what was taken for granted.
  /// Of a raster that was put in degrees; nothing where it takes more than most_bytes.
  std::optional<io::ResamplingError> resampling{};
  double read_seconds = 0;
  double build_seconds = 0;  ///< And writing.
};

/// Writes a raster as tiles of quantized-mesh 1.0: `folder`/Z/X/Y.terrain and, last, layer.json,
/// which says what tiles there are and their measured errors. The folder is made, or is empty; it
/// is filled whole or not at all. Heights above something other than the ellipsoid are transformed
/// where the file, or what is declared, says what they are above. Fails on rasters that are not in
/// degrees, on units of heights that are not known, on heights beyond kMostTileHeight, on more than
/// 2^22 tiles that nobody asked for, and as reading does.
[[nodiscard]] Result<TerrainTileReport> write_terrain_tiles(const std::string& path,
                                                            const io::HeightReadOptions& reading,
                                                            const TerrainTileOptions& options,
                                                            const std::string& folder,
                                                            Progress& progress);

}  // namespace lode
