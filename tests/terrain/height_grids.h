#pragma once

#include <functional>

#include "lode/core/height_grid.h"

namespace lode::test {

/// Of float32.
inline HeightGrid float_grid(int n_columns, int n_rows,
                             const std::function<double(int x, int y)>& height) {
  HeightGrid grid = make_height_grid<float>(n_columns, n_rows);
  auto& heights = std::get<HeightGrid::Samples<float>>(grid.heights);
  for (int y = 0; y < n_rows; ++y)
    for (int x = 0; x < n_columns; ++x)
      heights[static_cast<std::size_t>(y * grid.stride + x)] = static_cast<float>(height(x, y));
  return grid;
}

}  // namespace lode::test
