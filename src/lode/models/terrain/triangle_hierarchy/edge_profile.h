#pragma once

#include <cstdint>

#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"

namespace lode::triangle_hierarchy {

/// A vertex of a triangulation over a fine grid.
struct Place {
  LatticePoint at;  ///< Fine.
  double height = 0;
};

/// Where the profile of an edge is furthest from it.
struct EdgeSplit {
  double error = 0;       ///< 0: it crosses no column or row between its ends, or errs nowhere.
  Place place;            ///< The crossing, moved along its column or row onto the fine lattice.
  bool is_exact = false;  ///< The place lies on the edge.
};

/// Which crossings may become vertices.
enum class Crossings : std::uint8_t {
  all,
  exact  ///< Those at fine nodes alone, so all samples on the edge.
};

/// The error of an edge, as the models of paper 004, section 7, want it: its profile is read where
/// it crosses columns and rows, linear between the two samples there, and held against the edge.
/// From the edge alone, whichever end comes first, so that both triangles at it agree; of equal
/// errors the first counts, along columns and then rows, from the end that is first in rows.
/// O(crossings).
[[nodiscard]] EdgeSplit worst_crossing(const FineGrid& grid, Place a, Place b,
                                       Crossings crossings = Crossings::all);

}  // namespace lode::triangle_hierarchy
