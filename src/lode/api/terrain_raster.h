#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "lode/api/opened_terrain.h"
#include "lode/api/terrain.h"
#include "lode/core/height_frame.h"
#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/raster_file.h"

namespace lode {

struct TerrainRasterOptions {
  /// Of the raster: width and height of a pixel in units of the CRS, > 0; pixels' corners are at
  /// multiples of it, rows from north to south. Without: the grid of the raster that the terrain is
  /// of.
  std::optional<double> cell{};
  /// Another raster to write, of the heights in the first less the samples; empty: none. Only on
  /// the grid of a raster whose samples are at hand, or given.
  std::string difference{};
  /// The raster that a model is of, where it has not all heights itself; null: not given. Refused
  /// where it is another one: on another grid, or with a height that the model's TIN is farther
  /// from than it says.
  std::shared_ptr<const HeightGrid> samples{};
  std::string samples_name{};                                  ///< Its path, for messages.
  std::function<std::string(const TerrainReport&)> comment{};  ///< For both files.
  Threads threads{};
};

/// What `error` of a TerrainRasterReport is.
enum class RasterErrorKind : std::uint8_t {
  measured,  ///< The largest |z - z'| of samples and the heights written, over all samples.
  bound,     ///< No less than that: the samples are not at hand.
  of_tin,    ///< That of the TIN at what it was made of, which is not where the heights are.
};

struct TerrainRasterReport {
  TerrainReport terrain;
  HeightFrame frame;  ///< Of the raster.
  io::RasterType type = io::RasterType::float32;
  double nodata = 0;
  std::uint64_t n_heights = 0;
  RasterErrorKind error_kind = RasterErrorKind::measured;
  double error = 0;
  double rounding = 0;  ///< Heights written are not farther from the TIN's planes.
  double sample_seconds = 0;
  double write_seconds = 0;
};

/// Writes the heights of a terrain's TIN as a GeoTIFF, see io::RasterWriter, and perhaps
/// differences; each whole or not at all. Samples outside of the domain get the raster's own nodata
/// value, where it has one that no height equals, else the lowest float32.
///
/// Of a raster's own grid heights are rounded to the nearest float32, or to that beside it where
/// only so they keep the TIN's error; and are float64 where no float32 does. In memory: strips of
/// 256 rows, one for each thread.
///
/// Fails as extract_terrain() and io::RasterWriter do, and where options do not fit the terrain.
[[nodiscard]] Result<TerrainRasterReport> write_terrain_raster(const OpenedTerrain& opened,
                                                               const TerrainOptions& options,
                                                               const TerrainRasterOptions& wanted,
                                                               const std::string& path,
                                                               Progress& progress);

}  // namespace lode
