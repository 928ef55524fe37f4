#pragma once

#include <cstdint>

#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/height_reader.h"

namespace lode::io {

/// Rows of a file's raster.
struct RasterRows {
  std::int32_t first = 0;
  std::int32_t n = 0;
};

/// All but the samples, whose types and encoding are checked; place and CRS are as the file says.
[[nodiscard]] Result<HeightRaster> describe_raster(const GdalRaster& raster,
                                                   const HeightReadOptions& options);

/// The samples of some rows, without a place. `progress`: null, or told, and asked whether it is
/// cancelled.
[[nodiscard]] Result<HeightGrid> read_rows(const GdalRaster& raster,
                                           const HeightReadOptions& options, RasterRows rows,
                                           Progress* progress);

}  // namespace lode::io
