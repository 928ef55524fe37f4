#pragma once

#include <cstdint>
#include <vector>

#include "lode/models/terrain/triangle_hierarchy/reference_surface.h"

namespace lode::hierarchical_delaunay {

using triangle_hierarchy::Place;
using triangle_hierarchy::ReferenceSurface;

/// A vertex between the ends of an edge.
struct ChainPlace {
  Place place;
  std::int32_t n_moves = 0;  ///< It, or one of those that it was found between, onto the lattice.
};

/// The vertices that an edge is refined by, from a to b, until it errs by no more than the limit at
/// its crossings, or at those whose places are on it: its worst crossing
/// splits it, and so on (D. Douglas, T. Peucker 1973). From the edge alone; backwards from b to a.
[[nodiscard]] std::vector<ChainPlace> refine_edge(const ReferenceSurface& surface,
                                                  const ChainPlace& a, const ChainPlace& b,
                                                  double limit,
                                                  triangle_hierarchy::Crossings crossings);

}  // namespace lode::hierarchical_delaunay
