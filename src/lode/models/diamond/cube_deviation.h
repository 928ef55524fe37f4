#pragma once

#include <algorithm>

#include "lode/core/progress.h"
#include "lode/models/diamond/extract.h"

namespace lode::diamond {

/// How far a surface in the style of cubes is from the level set of F.
struct CubeDeviation {
  double error = 0;     ///< Largest |F - isovalue| on its triangles, but for rounding. Field units.
  double distance = 0;  ///< No point of them is farther from F = isovalue. World units.

  void join(const CubeDeviation& other) {
    error = std::max(error, other.error);
    distance = std::max(distance, other.distance);
  }
};

/// Measures what the query's full resolution in the style of cubes makes of a model without holes,
/// cell by cell from the samples: each triangle is cut by the cell's tetrahedra, on which F is
/// linear, and distances to the level set in one of them are convex, so both are largest at corners
/// of the pieces. About a microsecond a cell.
[[nodiscard]] Result<CubeDeviation> measure_cubes(const Model<3>& model,
                                                  const IsosurfaceQuery& query, Progress& progress);

}  // namespace lode::diamond
