#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/delaunay/lattice.h"

namespace lode::delaunay {

/// A raster's lattice cut along columns and rows into tiles, which share the nodes of those.
class TileLayout {
 public:
  /// Tiles that are about `side` steps wide and high, and as equal as can be. At least 2 x 2 nodes.
  TileLayout(std::int32_t n_columns, std::int32_t n_rows, std::int32_t side)
      : columns_(cut(n_columns - 1, side)), rows_(cut(n_rows - 1, side)) {}

  /// Columns that are cut along, with the first and the last of all; and rows.
  [[nodiscard]] const std::vector<std::int32_t>& columns() const { return columns_; }
  [[nodiscard]] const std::vector<std::int32_t>& rows() const { return rows_; }
  [[nodiscard]] std::size_t n_across() const { return columns_.size() - 1; }
  [[nodiscard]] std::size_t n_tiles() const { return n_across() * (rows_.size() - 1); }
  /// Tiles are numbered by rows of them.
  [[nodiscard]] LatticePart part(std::size_t tile) const {
    const std::size_t i = tile % n_across();
    const std::size_t j = tile / n_across();
    return {{columns_[i], rows_[j]}, {columns_[i + 1], rows_[j + 1]}};
  }

 private:
  [[nodiscard]] static std::vector<std::int32_t> cut(std::int32_t n_steps, std::int32_t side) {
    const std::int64_t n = std::max(1, (n_steps + side / 2) / side);
    std::vector<std::int32_t> places;
    for (std::int64_t i = 0; i <= n; ++i)
      places.push_back(static_cast<std::int32_t>(n_steps * i / n));
    return places;
  }

  std::vector<std::int32_t> columns_;
  std::vector<std::int32_t> rows_;
};

}  // namespace lode::delaunay
