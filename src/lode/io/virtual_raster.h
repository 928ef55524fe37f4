#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/covered_area.h"

namespace lode::io {

/// Where samples come from or go to, in columns and rows.
using VirtualPart = Rectangle;

/// A band of a file that is part of a mosaic's.
struct VirtualSource {
  std::string path;         ///< Of the file.
  int band = 1;             ///< Of its bands.
  bool is_of_mask = false;  ///< Its mask, instead.
  std::string resampling{};
  std::optional<VirtualPart> from{};  ///< Of the file; all of it, without.
  std::optional<VirtualPart> part{};  ///< Of the mosaic, likewise.
  std::optional<double> nodata{};     ///< Samples with this are left out,
  bool uses_mask = false;             ///< or those that the file's own mask says are none.
  double scale = 1;                   ///< Of its numbers in the mosaic,
  double offset = 0;                  ///< after which this is added.

  [[nodiscard]] bool is_plain() const { return !nodata && !uses_mask && scale == 1 && offset == 0; }
};

/// A band of a mosaic.
struct VirtualBand {
  std::string type;                ///< As GDAL names it.
  std::optional<double> nodata{};  ///< What samples without a source have; without, they have 0.
  bool has_odd_nodata = false;     ///< There is one, but no number of this type.
  std::string unit{};
  double scale = 1;  ///< What its numbers stand for.
  double offset = 0;
  bool is_opacity = false;
  std::vector<VirtualSource> sources{};
};

/// GDAL's VRT of the kind that gdalbuildvrt makes: bands put together from those of other files.
struct VirtualRaster {
  std::int32_t n_columns = 0;
  std::int32_t n_rows = 0;
  std::string crs{};           ///< As the file has it.
  std::string axes{};          ///< Its dataAxisToSRSAxisMapping.
  std::string geotransform{};  ///< As the file has it; empty: none.
  bool is_of_points = false;   ///< AREA_OR_POINT
  std::vector<VirtualBand> bands{};
  std::optional<VirtualBand> mask{};  ///< Of all of them.
};

/// Whether a file is one, by its name or its first bytes.
[[nodiscard]] bool is_virtual_raster(const std::string& path);

/// Reads one, of up to 256 MiB, without what it is put together from. Fails on all others:
/// warped or pansharpened ones, bands that are computed or read as raw bytes, tables of values,
/// sources that are no files.
[[nodiscard]] Result<VirtualRaster> read_virtual_raster(const std::string& path);

/// How many samples of a band no source covers, whose parts are rounded outward as GDAL does.
[[nodiscard]] std::uint64_t uncovered_samples(const VirtualRaster& raster, const VirtualBand& band);

}  // namespace lode::io
