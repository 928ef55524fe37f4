#pragma once

#include "lode/core/parallel.h"
#include "lode/core/surface.h"

namespace lode::bench {

/// Distances found at points, so never too large: from each of two surfaces to the other.
struct TwoSidedDistance {
  double from_first = 0;
  double from_second = 0;
};

/// Measures at all corners, and at points on all triangles no farther apart than `spacing`: the
/// exact distance to the nearest triangle of the other surface. Knows nothing of how either came.
[[nodiscard]] TwoSidedDistance measure_distance(const Surface& first, const Surface& second,
                                                double spacing, Threads threads);

}  // namespace lode::bench
