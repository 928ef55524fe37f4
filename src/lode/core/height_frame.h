#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "lode/core/vec.h"

namespace lode {

/// Where the nodes of a lattice, column x and row y, lie in the world, and in what its heights are.
struct HeightFrame {
  std::int32_t n_columns = 0;
  std::int32_t n_rows = 0;
  /// World x = g[0] + g[1] x + g[2] y and world y = g[3] + g[4] x + g[5] y.
  std::array<double, 6> to_world{0, 1, 0, 0, 0, 1};
  std::string crs;            ///< As WKT; empty: not known.
  std::string vertical_unit;  ///< Empty: not known.
  bool is_round = false;      ///< The last column is the first again, all the way round the earth.

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

/// Of the nodes of a lattice 2^bits times as fine, which has the same corners.
[[nodiscard]] HeightFrame fine_frame(const HeightFrame& frame, int bits);

/// The lowest and highest heights; lower > upper where there are none.
struct HeightRange {
  double lower = 0;
  double upper = -1;
};

}  // namespace lode
