#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/tile_pyramid/extended_raster.h"
#include "lode/models/terrain/tile_pyramid/tile_scheme.h"

namespace lode::tile_pyramid {

/// A side of a tile: the west one, from south to north, or the south one, from west to east. Those
/// in the east and north are sides of other tiles, whether these are there or not.
struct TileSide {
  TileId tile;
  bool is_west = false;
};

/// Heights along a side, linear between places, of which there is one at least.
struct Profile {
  std::vector<double> at;  ///< In nodes of the side, rising; also beyond its ends.
  std::vector<double> heights;

  [[nodiscard]] double height(double node) const;
};

/// The surface along all borders of the tiles of one level, and the heights in these tiles. Sides
/// of coarser levels lie on these borders, or where there is no raster. Memory: a double for each
/// sample on a border.
class BorderLines {
 public:
  static constexpr std::int64_t kStripRows = 256;

  /// Reads the raster once.
  [[nodiscard]] static Result<BorderLines> scan(HeightRows& rows, const ExtendedRaster& raster,
                                                const TileRange& finest, Threads threads,
                                                Progress& progress);

  /// Of a side of the finest level or a coarser one.
  [[nodiscard]] Profile profile(const TileSide& side) const;

  /// Of all heights in a tile of the finest level, and of a cell round it.
  [[nodiscard]] const HeightRange& range(std::int64_t x, std::int64_t y) const {
    return ranges_[index(x, y)];
  }

 private:
  explicit BorderLines(const ExtendedRaster& raster, const TileRange& finest);

  [[nodiscard]] std::size_t index(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>((y - finest_.first_y) * finest_.n_columns() +
                                    wrapped_column(finest_.level, x - finest_.first_x));
  }
  void add_meridian(std::size_t line, const RowStrip& strip, IndexRange rows);
  void add_parallel(std::size_t line, const RowStrip& strip, IndexRange rows);
  void add_range(std::size_t tile, const RowStrip& strip, IndexRange rows);
  [[nodiscard]] Profile along_meridian(const TileSide& side) const;
  [[nodiscard]] Profile along_parallel(const TileSide& side) const;

  ExtendedRaster raster_;
  TileRange finest_;
  std::vector<std::vector<double>> meridians_;  ///< By row; empty: the fill.
  std::vector<std::vector<double>> parallels_;  ///< By column.
  std::vector<HeightRange> ranges_;
};

}  // namespace lode::tile_pyramid
