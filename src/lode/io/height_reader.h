#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/height_formats.h"
#include "lode/io/vertical_options.h"

namespace lode::io {

/// What the colours of a picture stand for. terrain_rgb: -10000 + 0.1 (65536 R + 256 G + B) metres;
/// terrarium: 256 R + G + B / 256 - 32768 metres.
enum class HeightEncoding : std::uint8_t { none, terrain_rgb, terrarium };

/// How heights between samples are found: that of the nearest one, or from 2 x 2 or 4 x 4.
enum class Resampling : std::uint8_t { nearest, bilinear, cubic };

struct HeightReadOptions {
  /// Of a raster, from 1; of netCDF the layer along dimensions but the last two. None: the first,
  /// of netCDF the only one.
  std::optional<int> band{};
  std::string variable{};  ///< Of netCDF, in groups as "deep/z"; empty: the only one.
  HeightEncoding encoding = HeightEncoding::none;
  std::optional<double> nodata{};  ///< Instead of what the file says.
  /// As WKT, EPSG:N or EPSG:N+M, of a raster whose file says none; empty: not known.
  std::string crs{};
  VerticalOptions vertical{};
  /// Put a raster in degrees of WGS 84, as far apart as its samples are: these are other samples,
  /// which errors are then of. Heights stay above what they are above. Of what GDAL reads only, and
  /// of no encoding.
  std::optional<Resampling> to_degrees{};
  int oversampling = 1;  ///< Then: so many samples along each axis for one of the file's, or more.

  [[nodiscard]] int band_or_first() const { return band.value_or(1); }
};

/// What the heights of a raster file are put in, for files that are to be like it.
struct RasterForm {
  /// GDAL's: places of pixels' corners; none: the file has no position.
  std::optional<std::array<double, 6>> geotransform{};
  std::optional<double> nodata{};  ///< Of missing samples, as stored; none: not by a value.
  bool is_point = false;           ///< AREA_OR_POINT=Point: samples are at places, not of pixels.
};

/// A raster of heights and what its file says of it.
struct HeightRaster {
  HeightGrid grid;
  std::string format;      ///< GDAL's name, such as GTiff, or HGT.
  std::string type;        ///< Of the file's samples: int16, scaled int16, terrain-rgb, ...
  bool has_place = false;  ///< Else the world is columns, and rows counted from the last one up.
  RasterForm form{};
  VerticalOutcome vertical{};
};

/// Reads a raster of heights: .hgt and .hgt.gz (SRTM, named like N46W123), all else through GDAL,
/// of netCDF what import_raster() makes of it.
/// Samples are taken at the middle of pixels, wherever AREA_OR_POINT says that the file's position
/// is. Missing are samples that equal the nodata value, are masked, or no finite numbers. Heights
/// are in the unit of the CRS's vertical part, where it has one, and set_vertical() is done. Fails,
/// naming the file, on what is missing, truncated, not a raster, or claims more samples than a file
/// of its size can hold.
[[nodiscard]] Result<HeightRaster> read_heights(const std::string& path,
                                                const HeightReadOptions& options,
                                                Progress& progress);

}  // namespace lode::io
