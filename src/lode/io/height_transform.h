#pragma once

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/height_reader.h"
#include "lode/io/point_file.h"
#include "lode/io/vertical_crs.h"

namespace lode::io {

/// Gives heights that were read the vertical CRS that the options declare, and transforms them to
/// their target; raster or points then have the unit and the CRS, compound or three-dimensional,
/// that fit. Transformed heights are float64.
///
/// Heights are transformed one by one where they are, all by one transformation: that of known
/// accuracy which PROJ names first and has the grids for. Fails where it has none, naming the grids
/// that better ones need, never taking a guess; on samples off the grid; and when cancelled.
[[nodiscard]] Result<VerticalOutcome> set_vertical(HeightRaster& raster,
                                                   const VerticalOptions& options,
                                                   Progress& progress);
[[nodiscard]] Result<VerticalOutcome> set_vertical(PointFile& file, const VerticalOptions& options,
                                                   Progress& progress);

}  // namespace lode::io
