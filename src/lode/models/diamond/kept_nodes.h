#pragma once

#include "lode/models/diamond/coarse_field.h"

namespace lode::diamond {

/// The nodes with these centres are a brick's own.
[[nodiscard]] inline LatticeBox<3> own_centres(const Index<3>& brick, const Index<3>& dims) {
  LatticeBox<3> own{brick * kBrickEdge<3>, {}};
  for (std::size_t a = 0; a < 3; ++a) {
    own.upper[a] = own.lower[a] + kBrickEdge<3>;
    if (own.upper[a] == dims[a] - 1) ++own.upper[a];  // no other brick has the last sample
    own.upper[a] = std::min(own.upper[a], dims[a]);
  }
  return own;
}

/// Whether is(place on the level's grid, and among its attributes) holds for a node of level
/// kKeptLevel inside a brick or on its border: those that finer nodes with a centre there come
/// after, directly or not.
template <int D, typename Is>
bool any_kept_node(const Shape<D>& shape, const Index<D>& brick, const Is& is) {
  const Index<D> dims = shape.grid_dims(kKeptLevel);
  const std::int32_t n = kBrickEdge<D> >> kKeptLevel;
  const Index<D> edges = all_equal<D>(n + 1);
  for (std::size_t i = 0; i < n_points<D>(edges); ++i) {
    const Index<D> q = brick * n + point_of<D>(edges, i);
    std::int32_t odd = 0;
    bool exists = true;
    for (std::size_t a = 0; a < as_size(D); ++a) {
      odd |= q[a] & 1;
      exists = exists && q[a] < dims[a];
    }
    if (odd != 0 && exists && is(q, linear_index<D>(dims, q))) return true;
  }
  return false;
}

}  // namespace lode::diamond
