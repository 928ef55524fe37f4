#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/result.h"

namespace lode::io {

/// Where samples come from or go to, in columns and rows.
struct VirtualPart {
  double left = 0;
  double top = 0;
  double right = 0;
  double bottom = 0;
};

/// A band of a file that is part of a mosaic's.
struct VirtualSource {
  std::string path;       ///< Of the file, as GDAL opens it.
  int band = 1;           ///< Of its bands; 0: its mask.
  bool is_copied = true;  ///< All samples, those too that the file itself says are none.
  std::optional<VirtualPart> from{};  ///< Of the file; all of it, without.
  std::optional<VirtualPart> part{};  ///< Of the mosaic, likewise.
};

/// A band of a mosaic.
struct VirtualBand {
  int number = 1;
  std::optional<double> nodata{};  ///< What samples without a source have; without, they have 0.
  bool is_opacity = false;
  std::vector<VirtualSource> sources{};
};

/// GDAL's VRT of the kind that gdalbuildvrt makes: bands put together from those of other files.
struct VirtualRaster {
  std::int32_t n_columns = 0;
  std::int32_t n_rows = 0;
  bool has_mask = false;
  std::vector<VirtualBand> bands{};
};

/// Whether a file is one, by its name or its first bytes.
[[nodiscard]] bool is_virtual_raster(const std::string& path);

/// Reads one, of up to 256 MiB, without what it is put together from. Fails on all others:
/// warped or pansharpened ones, bands that are computed or read as raw bytes, sources that are no
/// files.
[[nodiscard]] Result<VirtualRaster> read_virtual_raster(const std::string& path);

/// How many samples of a band no source covers, whole ones.
[[nodiscard]] double uncovered_samples(const VirtualRaster& raster, const VirtualBand& band);

}  // namespace lode::io
