#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/mappers/facet_grid.h"

namespace lode {

/// Whether all points of one facet are near some of others.
struct FacetProof {
  bool holds = false;
  double bound = 0;                          ///< How far at most, where it holds.
  std::uint32_t witness = FacetGrid::kNone;  ///< The one it is near to, where a single one is.
};

struct NearnessQuery {
  double limit = 0;
  int n_most_pieces = 0;                  ///< What takes more fails.
  std::uint32_t hint = FacetGrid::kNone;  ///< One that may be near, which saves a search.
};

/// Proves that no point of a facet is farther than a limit from all facets of `others`. The
/// distance to a facet, a convex set, is a convex function: a piece whose three corners are within
/// the limit of one facet is so everywhere; and so is one that lies in a ball of the limit's radius
/// round a point of a facet. Other pieces are cut in four, long ones in two, until one has a middle
/// that is farther than the limit from every facet, or they are too small to matter. Bounds are
/// rounded up.
[[nodiscard]] FacetProof prove_near(const Facet& facet, const FacetGrid& others,
                                    const NearnessQuery& query);

/// What rounding may add to distances between points with such coordinates.
[[nodiscard]] inline double distance_rounding(double largest_coordinate) {
  return 0x1p-46 * largest_coordinate;
}

}  // namespace lode
