#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/delaunay/tin.h"
#include "lode/mappers/simple_rings.h"

namespace lode {

/// A connected part of what of a TIN lies between two neighbouring levels, in columns and rows.
/// Rings have each point once but for the last; several may touch in points.
struct BandPolygon {
  std::uint32_t band = 0;  ///< The number of levels below it.
  RingPolygon rings;
};

/// The bands {lower <= z < upper} of a TIN between levels that rise strictly, and of what is below
/// the first and above the last: bounded by the contours that trace_contours() finds, by the same
/// points, and by the outline. Together they cover the domain once. Parts without area, which ties
/// may make, are left out. O((triangles + points) log n) usually; holes are sought among the outer
/// rings of the same part. Fails when cancelled.
[[nodiscard]] Result<std::vector<BandPolygon>> find_bands(const delaunay::Tin& tin,
                                                          std::span<const double> levels,
                                                          Progress& progress);

}  // namespace lode
