#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/lattice_point.h"

namespace lode::delaunay {

/// The corners of the convex hull of points, by their numbers, turning left from the first in rows;
/// points inside of its edges are none. Of points on one line the two ends, of one point itself.
/// The points are different and in rows: by y, then x; coordinates as of doubled_area(). O(n).
[[nodiscard]] std::vector<std::uint32_t> convex_hull(std::span<const LatticePoint> points);

}  // namespace lode::delaunay
