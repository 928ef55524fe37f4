#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/lattice_point.h"

namespace lode::tile_pyramid {

/// The last node of a tile's lattice, which runs from 0 to it both ways: quantized-mesh 1.0.
inline constexpr std::int32_t kLastNode = 32767;
inline constexpr int kMaxLevel = 22;

/// A tile of the global geodetic scheme (TMS): level z has 2^(z + 1) x 2^z tiles, counted from
/// longitude -180 and latitude -90.
struct TileId {
  int level = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;

  bool operator==(const TileId&) const = default;
};

/// Degrees that a tile of the level is wide and high.
[[nodiscard]] double tile_size(int level);

/// Degrees; of a column that is called what it is.
[[nodiscard]] double west_of(const TileId& tile);
[[nodiscard]] double south_of(const TileId& tile);

/// Tiles of a level, both ends included. Columns may run on beyond 180 degrees, at most once round:
/// column() is what they are called.
struct TileRange {
  int level = 0;
  std::int64_t first_x = 0, last_x = -1;
  std::int64_t first_y = 0, last_y = -1;

  [[nodiscard]] std::int64_t n_columns() const { return last_x - first_x + 1; }
  [[nodiscard]] std::int64_t n_rows() const { return last_y - first_y + 1; }
  [[nodiscard]] std::uint64_t n_tiles() const {
    return static_cast<std::uint64_t>(n_columns() * n_rows());
  }
  /// Whether there is such a tile, whatever the column is called.
  [[nodiscard]] bool holds(std::int64_t x, std::int64_t y) const;
};

/// What a column is called: from 0 to 2^(level + 1) - 1.
[[nodiscard]] std::int64_t wrapped_column(int level, std::int64_t x);

/// A part of the world in degrees; west < east, which may be beyond 180.
struct DegreeBox {
  double west = 0, south = 0, east = 0, north = 0;
};

/// The tiles that a part of the world meets with more than its border, of levels 0 to `last`; of
/// level 0 both. Each tile's parent is there. Of a part that goes round the world all columns.
[[nodiscard]] std::vector<TileRange> tiles_of(const DegreeBox& box, int last);

}  // namespace lode::tile_pyramid
