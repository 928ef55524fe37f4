#pragma once

#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/uninitialized_array.h"

namespace lode {

/// Heights over the nodes of a lattice, kept exactly as the file has them:
/// integers of 8 and 16 bits as int16 or uint16, those of 32 bits as float64.
///
/// Row y starts at y * stride, and kPadding more samples follow the last row, so that vectors may
/// be loaded from any sample on; what lies there means nothing.
struct HeightGrid : HeightFrame {
  template <typename T>
  using Samples = UninitializedArray<T>;
  using Heights =
      std::variant<Samples<std::int16_t>, Samples<std::uint16_t>, Samples<float>, Samples<double>>;

  static constexpr std::int64_t kPadding = 64;

  std::int64_t stride = 0;             ///< In samples.
  Heights heights;                     ///< Finite wherever valid.
  std::vector<std::uint8_t> is_valid;  ///< Of n_columns * n_rows; empty: all are.

  [[nodiscard]] std::int64_t n_samples() const { return std::int64_t{n_columns} * n_rows; }
  [[nodiscard]] bool has_height(std::int32_t x, std::int32_t y) const {
    return is_valid.empty() || is_valid[static_cast<std::size_t>(std::int64_t{y} * n_columns + x)];
  }
  /// Exactly.
  [[nodiscard]] double height(std::int32_t x, std::int32_t y) const;
  [[nodiscard]] std::uint64_t n_missing() const;
};

/// The distance of rows for HeightGrid::stride: whole vectors, and no power of two, rows of which
/// would share their places in a cache. Of n_columns > 0.
[[nodiscard]] std::int64_t padded_stride(std::int32_t n_columns);

/// All samples of this type, valid and not yet set.
template <typename T>
[[nodiscard]] HeightGrid make_height_grid(std::int32_t n_columns, std::int32_t n_rows) {
  HeightGrid grid;
  grid.n_columns = n_columns;
  grid.n_rows = n_rows;
  grid.stride = padded_stride(n_columns);
  grid.heights.emplace<HeightGrid::Samples<T>>(
      static_cast<std::size_t>(grid.stride * n_rows + HeightGrid::kPadding));
  return grid;
}

/// Of the valid heights.
[[nodiscard]] HeightRange height_range(const HeightGrid& grid);

}  // namespace lode
