#include "lode/models/terrain/tile_pyramid/tile_scheme.h"

#include <algorithm>
#include <cmath>

namespace lode::tile_pyramid {
namespace {

constexpr double kWest = -180;
constexpr double kSouth = -90;

std::int64_t n_columns_of(int level) { return std::int64_t{2} << level; }
std::int64_t n_rows_of(int level) { return std::int64_t{1} << level; }

}  // namespace

double tile_size(int level) { return std::ldexp(180.0, -level); }

double west_of(const TileId& tile) {
  return kWest + static_cast<double>(tile.x) * tile_size(tile.level);
}
double south_of(const TileId& tile) {
  return kSouth + static_cast<double>(tile.y) * tile_size(tile.level);
}

std::int64_t wrapped_column(int level, std::int64_t x) {
  const std::int64_t n = n_columns_of(level);
  return ((x % n) + n) % n;
}

bool TileRange::holds(std::int64_t x, std::int64_t y) const {
  return y >= first_y && y <= last_y && wrapped_column(level, x - first_x) < n_columns();
}

std::vector<TileRange> tiles_of(const DegreeBox& box, int last) {
  const double size = tile_size(last);
  TileRange finest{.level = last};
  finest.first_x = static_cast<std::int64_t>(std::floor((box.west - kWest) / size));
  finest.last_x = static_cast<std::int64_t>(std::ceil((box.east - kWest) / size)) - 1;
  finest.last_x = std::max(finest.last_x, finest.first_x);
  if (finest.n_columns() >= n_columns_of(last)) {
    finest.first_x = 0;
    finest.last_x = n_columns_of(last) - 1;
  }
  const auto row = [&](double y) {
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(y), 0, n_rows_of(last) - 1);
  };
  finest.first_y = row(std::floor((box.south - kSouth) / size));
  finest.last_y = std::max(finest.first_y, row(std::ceil((box.north - kSouth) / size) - 1));

  std::vector<TileRange> ranges(static_cast<std::size_t>(last) + 1, finest);
  for (int level = last - 1; level >= 0; --level) {
    TileRange& range = ranges[static_cast<std::size_t>(level)];
    const TileRange& finer = ranges[static_cast<std::size_t>(level) + 1];
    // Shifts round towards what is less, also of negative numbers.
    range = {level, finer.first_x >> 1, finer.last_x >> 1, finer.first_y >> 1, finer.last_y >> 1};
    if (range.n_columns() >= n_columns_of(level)) {
      range.first_x = 0;
      range.last_x = n_columns_of(level) - 1;
    }
  }
  ranges[0].last_x = ranges[0].first_x + 1;
  return ranges;
}

}  // namespace lode::tile_pyramid
