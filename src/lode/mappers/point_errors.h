#pragma once

#include <cstdint>

#include "lode/core/height_points.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"
#include "lode/mappers/tin_quality.h"

namespace lode {

/// How many of a TIN's triangles state less than the error of a point in them or on their edges. It
/// may be all triangles of many times. It has heights and errors, and its vertices are nodes of the
/// points' lattice. Errors are computed in 64 bits of mantissa. Fails when cancelled.
[[nodiscard]] Result<std::uint64_t> count_understated_points(const delaunay::Tin& tin,
                                                             const HeightPoints& points,
                                                             Threads threads, Progress& progress);

/// As measure_quality(), of a TIN of scattered points, from one step of whose lattice to the next
/// there are `scale` nodes of the TIN's. Errors are computed in 64 bits of mantissa.
[[nodiscard]] TinQuality measure_point_quality(const delaunay::Tin& tin, std::int32_t scale,
                                               const HeightPoints& points, Threads threads);

}  // namespace lode
