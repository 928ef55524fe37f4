#pragma once

#include <array>
#include <cstdint>

#include "lode/models/terrain/triangle_hierarchy/edge_profile.h"

namespace lode::triangle_hierarchy {

/// Edges of a triangle; bit i: the one from corner i to corner i + 1.
using EdgeSet = std::uint8_t;
inline constexpr EdgeSet kNoEdges = 0;
inline constexpr EdgeSet kAllEdges = 7;

struct SampleErrors {
  double closed = 0;  ///< The largest of all samples in the closed triangle.
  double inner = 0;   ///< The largest of those that may be inserted,
  LatticePoint at;    ///< and where that is, fine, if it is not 0; the first in rows of equals.
};

/// |z - z'| at all samples in a triangle that turns left, z' between its corners. Those that may be
/// inserted lie inside, or on an edge in `open`, and at no corner. Each sample is found exactly,
/// and its error is off by less than grid.rounding(), however thin the triangle is.
/// O(rows + samples).
[[nodiscard]] SampleErrors measure_samples(const FineGrid& grid,
                                           const std::array<Place, 3>& corners, EdgeSet open);

}  // namespace lode::triangle_hierarchy
