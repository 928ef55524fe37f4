#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/squares/square_domain.h"

namespace lode::restricted_quadtree {

using squares::Square;
using squares::SquareDomain;

/// Which sides of a square have their midpoints in its pattern: bit 0 the lower one, then right,
/// upper, left (x to the right, y up).
using SideMask = std::uint8_t;

inline constexpr SideMask kAllSides = 0b1111;

/// A leaf, cut into triangles round its centre: the six patterns of the paper's figure 11, turned.
/// Cells have two triangles and no midpoints.
struct Leaf {
  Square square;
  SideMask midpoints = 0;
  double error = 0;  ///< A bound of its samples'.

  friend bool operator==(const Leaf&, const Leaf&) = default;
};

/// A bound of |z - z'| of the samples in a square larger than a cell that is wholly in the domain,
/// z' on the triangles of a pattern: the largest, and SquareDomain::rounding_in() more, but where
/// all samples are corners.
[[nodiscard]] double pattern_error(const SquareDomain& domain, const Square& square,
                                   SideMask midpoints);

/// The restricted quadtree (B. Von Herzen, A. Barr, "Accurate triangulations of deformed,
/// intersecting surfaces", 1987) by the iterative top-down algorithm of L. De Floriani, P. Marzano,
/// E. Puppo 1996, section 6 and figure 12: neighbours differ by at most one level, and patterns of
/// triangles meet, so the surface is continuous, at this tolerance. A square whose pattern changes
/// is tested again on all its samples, and midpoints may be added for accuracy as well as for
/// balance, the fewest that do, and its neighbours are looked at again: so both hold in the end.
/// Squares partly outside the domain are split. Leaves come by levels, the largest first. One
/// thread. O(N log N) for N samples. Fails as SquareDomain::make() does, and when cancelled.
[[nodiscard]] Result<std::vector<Leaf>> build(const SquareDomain& domain, double tolerance,
                                              Progress& progress);

/// All leaves' triangles; errors are those of the leaves.
[[nodiscard]] delaunay::Tin to_tin(const SquareDomain& domain, const std::vector<Leaf>& leaves);

}  // namespace lode::restricted_quadtree
