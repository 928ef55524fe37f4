#pragma once

#include "lode/core/progress.h"
#include "lode/models/diamond/cube_meter.h"
#include "lode/models/diamond/extract.h"

namespace lode::diamond {

/// Measures what the query's full resolution in the style of cubes makes of a model without holes.
[[nodiscard]] Result<CubeDeviation> measure_cubes(const Model<3>& model,
                                                  const IsosurfaceQuery& query, Progress& progress);

}  // namespace lode::diamond
