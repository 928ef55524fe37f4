#include "lode/delaunay/grid_cells.h"

namespace lode::delaunay {

GridCells::GridCells(const HeightGrid& grid) : GridCells(grid.n_columns, grid.n_rows) {
  for (std::int32_t y = 0; y + 1 < n_rows_; ++y)
    for (std::int32_t x = 0; x + 1 < n_columns_; ++x)
      if (grid.has_height(x, y) && grid.has_height(x + 1, y) && grid.has_height(x, y + 1) &&
          grid.has_height(x + 1, y + 1))
        add(x, y);
}

GridCells::GridCells(const GridCells& all, const LatticePart& part)
    : GridCells(part.last.x - part.first.x + 1, part.last.y - part.first.y + 1) {
  for (std::int32_t y = 0; y + 1 < n_rows_; ++y)
    for (std::int32_t x = 0; x + 1 < n_columns_; ++x)
      if (all.has(part.first.x + x, part.first.y + y)) add(x, y);
}

std::uint64_t GridCells::count_samples() const {
  std::uint64_t n = 0;
  for (std::int32_t y = 0; y < n_rows_; ++y)
    for (std::int32_t x = 0; x < n_columns_; ++x)
      n += static_cast<std::uint64_t>(n_round(x, y) > 0);
  return n;
}

}  // namespace lode::delaunay
