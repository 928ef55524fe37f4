#pragma once

#include <cstdint>

#include "lode/core/height_points.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// How many of a TIN's triangles state less than the error of a point in them or on their edges. It
/// may be all triangles of many times. It has heights and errors, and its vertices are nodes of the
/// points' lattice. Errors are computed in 64 bits of mantissa. Fails when cancelled.
[[nodiscard]] Result<std::uint64_t> count_understated_points(const delaunay::Tin& tin,
                                                             const HeightPoints& points,
                                                             Threads threads, Progress& progress);

}  // namespace lode
