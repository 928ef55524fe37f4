#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/delaunay/lattice.h"

namespace lode::delaunay {

/// Which cells of a grid have four valid corners, with a border of cells outside all round. A byte
/// a cell.
class GridCells {
 public:
  explicit GridCells(const HeightGrid& grid);
  /// Those of a part of `all`, whose first node is column 0 and row 0 here.
  GridCells(const GridCells& all, const LatticePart& part);

  [[nodiscard]] std::int32_t n_columns() const { return n_columns_; }
  [[nodiscard]] std::int32_t n_rows() const { return n_rows_; }
  /// The cell between columns x, x + 1 and rows y, y + 1; -1 and the last ones are outside.
  [[nodiscard]] bool has(std::int32_t x, std::int32_t y) const { return is_inside_[at(x, y)] != 0; }
  [[nodiscard]] std::uint64_t n_inside() const { return n_inside_; }
  [[nodiscard]] bool has_all() const {
    return n_inside_ == static_cast<std::uint64_t>(std::int64_t{n_columns_ - 1} * (n_rows_ - 1));
  }
  /// Of the four cells round a node.
  [[nodiscard]] int n_round(std::int32_t x, std::int32_t y) const {
    return int{has(x - 1, y - 1)} + int{has(x, y - 1)} + int{has(x - 1, y)} + int{has(x, y)};
  }
  /// Whether the outline turns at a node, or touches itself there.
  [[nodiscard]] bool is_corner(std::int32_t x, std::int32_t y) const {
    const int n = n_round(x, y);
    return n == 1 || n == 3 || (n == 2 && has(x - 1, y - 1) == has(x, y));
  }
  /// Nodes that are corners of cells inside.
  [[nodiscard]] std::uint64_t count_samples() const;

 private:
  GridCells(std::int32_t n_columns, std::int32_t n_rows)
      : n_columns_(n_columns),
        n_rows_(n_rows),
        is_inside_(static_cast<std::size_t>(n_columns + 1) * static_cast<std::size_t>(n_rows + 1)) {
  }
  void add(std::int32_t x, std::int32_t y) {
    is_inside_[at(x, y)] = 1;
    ++n_inside_;
  }
  [[nodiscard]] std::size_t at(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y + 1) * static_cast<std::size_t>(n_columns_ + 1) +
           static_cast<std::size_t>(x + 1);
  }

  std::int32_t n_columns_;  ///< Of nodes.
  std::int32_t n_rows_;
  std::vector<std::uint8_t> is_inside_;
  std::uint64_t n_inside_ = 0;
};

}  // namespace lode::delaunay
