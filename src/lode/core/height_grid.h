#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "lode/core/uninitialized_array.h"
#include "lode/core/vec.h"

namespace lode {

/// Heights over the nodes of a lattice, column x and row y, kept exactly as the file has them:
/// integers of 8 and 16 bits as int16 or uint16, those of 32 bits as float64.
///
/// Row y starts at y * stride, and kPadding more samples follow the last row, so that vectors may
/// be loaded from any sample on; what lies there means nothing.
struct HeightGrid {
  template <typename T>
  using Samples = UninitializedArray<T>;
  using Heights =
      std::variant<Samples<std::int16_t>, Samples<std::uint16_t>, Samples<float>, Samples<double>>;

  static constexpr std::int64_t kPadding = 64;

  std::int32_t n_columns = 0;
  std::int32_t n_rows = 0;
  std::int64_t stride = 0;             ///< In samples.
  Heights heights;                     ///< Finite wherever valid.
  std::vector<std::uint8_t> is_valid;  ///< Of n_columns * n_rows; empty: all are.
  /// World x = g[0] + g[1] x + g[2] y and world y = g[3] + g[4] x + g[5] y, at the samples.
  std::array<double, 6> to_world{0, 1, 0, 0, 0, 1};
  std::string crs;            ///< As WKT; empty: not known.
  std::string vertical_unit;  ///< Empty: not known.

  [[nodiscard]] std::int64_t n_samples() const { return std::int64_t{n_columns} * n_rows; }
  [[nodiscard]] bool has_height(std::int32_t x, std::int32_t y) const {
    return is_valid.empty() || is_valid[static_cast<std::size_t>(std::int64_t{y} * n_columns + x)];
  }
  /// Exactly.
  [[nodiscard]] double height(std::int32_t x, std::int32_t y) const;
  [[nodiscard]] std::uint64_t n_missing() const;
  /// World x and y of a place in columns and rows.
  [[nodiscard]] Vec<double, 2> world(double x, double y) const;
  /// Columns and rows of a place in the world: the inverse of world().
  [[nodiscard]] Vec<double, 2> lattice(double x, double y) const;
  /// The same, but on a column or row where only rounding, also of a sample's place in the world,
  /// may have moved it off.
  [[nodiscard]] Vec<double, 2> snapped_lattice(double x, double y) const;
  /// Whether x and y turn the other way in the world, as they do where rows run from north to
  /// south.
  [[nodiscard]] bool is_mirrored() const {
    return to_world[1] * to_world[5] - to_world[2] * to_world[4] < 0;
  }
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

/// The lowest and highest valid heights; lower > upper where none is valid.
struct HeightRange {
  double lower = 0;
  double upper = -1;
};
[[nodiscard]] HeightRange height_range(const HeightGrid& grid);

}  // namespace lode
