#pragma once

#include <algorithm>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"

namespace lode {

/// The largest distance of any point of one surface from another: not less than `lower`, which a
/// point has, and not more than `upper`. Infinite where only the other is empty.
struct DistanceBounds {
  double lower = 0;
  double upper = 0;
};

/// Both ways, in world units.
struct SurfaceDistance {
  DistanceBounds from_first;
  DistanceBounds from_second;

  [[nodiscard]] double lower() const { return std::max(from_first.lower, from_second.lower); }
  [[nodiscard]] double upper() const { return std::max(from_first.upper, from_second.upper); }
};

struct DistanceOptions {
  double accuracy = 0;  ///< > 0, world units: bounds are no farther apart, but where a triangle
                        ///< would have to be cut into more than 16384 pieces for that.
  Threads threads{};
};

/// Measures how far two surfaces of triangles are from each other, whatever they come from.
/// Triangles are cut until what their points can differ by does not matter any more: smaller pieces
/// than the accuracy never. Takes about a microsecond for each triangle or piece. Fails when
/// cancelled.
[[nodiscard]] Result<SurfaceDistance> measure_distance(const Surface& first, const Surface& second,
                                                       const DistanceOptions& options,
                                                       Progress& progress);

}  // namespace lode
