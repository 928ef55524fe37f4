#pragma once

#include <span>
#include <vector>

#include "lode/core/vec.h"

namespace lode {

/// A closed line: its last point is its first.
using Ring = std::vector<Vec<double, 2>>;

/// Twice the area that a ring turns left round; negative where it turns right.
[[nodiscard]] double doubled_area(const Ring& ring);

/// A ring that may come back to its points, cut there into rings that have each point once and that
/// have an area; what is run along there and back goes. O(n log n).
[[nodiscard]] std::vector<Ring> cut_at_repeated_points(const Ring& ring);

/// The rings, a region on their left, of the region's inside: what two rings, or one, run along in
/// both directions goes, as it has no inside, and where rings meet in points they go on along the
/// same inside. Rings of an inside in one piece may come back to points. The rings must not cross.
/// O(n log n); orders round points are exact.
[[nodiscard]] std::vector<Ring> follow_inside(const std::vector<Ring>& rings);

/// An outer ring, which turns left, then its holes, which turn right.
using RingPolygon = std::vector<Ring>;

/// Polygons of rings that do not cross, each with the holes that it is the smallest outer ring
/// round; every hole is in one, and may touch it at points. By boxes, areas and crossings in
/// float64; the largest ring whose box holds a hole is round it where no smaller one is.
[[nodiscard]] std::vector<RingPolygon> nest_rings(std::vector<Ring> rings);

}  // namespace lode
