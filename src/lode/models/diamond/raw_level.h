#pragma once

#include <limits>
#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// Attributes while they are being computed: errors as float32 rounded up, ranges as computed.
template <typename C>
struct RawLevel {
  std::vector<float> error;
  std::vector<C> low;
  std::vector<C> high;

  explicit RawLevel(std::size_t n)
      : error(n, 0.0F),
        low(n, std::numeric_limits<C>::infinity()),
        high(n, -std::numeric_limits<C>::infinity()) {}
};

/// How a level's attributes are laid out: on its grid, level 0 as one per cube of side 2.
template <int D>
[[nodiscard]] Index<D> level_dims(const Shape<D>& shape, int level) {
  if (level > 0) return shape.grid_dims(level);
  Index<D> dims;
  for (int i = 0; i < D; ++i) dims[as_size(i)] = shape.n_cubes(0, i);
  return dims;
}

}  // namespace lode::diamond
