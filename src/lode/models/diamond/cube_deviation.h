#pragma once

#include "lode/core/progress.h"
#include "lode/models/diamond/cube_meter.h"
#include "lode/models/diamond/extract.h"

namespace lode::diamond {

/// Measures what the query's full resolution in the style of cubes makes of a model without holes.
[[nodiscard]] Result<CubeDeviation> measure_cubes(const Model<3>& model,
                                                  const IsosurfaceQuery& query, Progress& progress);

/// Of the cells at full resolution of a model without holes that the query's surface meets, the
/// share that keep to its limits as cubes, from one row in sixteen; 1 where that meets none.
[[nodiscard]] Result<double> share_of_cubes(const Model<3>& model, const IsosurfaceQuery& query,
                                            Progress& progress);

}  // namespace lode::diamond
