#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/result.h"
#include "lode/models/terrain/tile_pyramid/height_rows.h"
#include "lode/models/terrain/tile_pyramid/tile_scheme.h"

namespace lode::tile_pyramid {

/// Whole numbers, both ends included.
struct IndexRange {
  std::int64_t first = 0;
  std::int64_t last = -1;

  [[nodiscard]] bool is_empty() const { return last < first; }
};

/// A place between two columns or rows, `part` of the way from the first to the next.
struct Between {
  std::int64_t first = 0;
  double part = 0;

  [[nodiscard]] double mix(double a, double b) const { return part == 0 ? a : a + part * (b - a); }
};

/// Where the samples of a raster in degrees lie on the globe. It is continued: by one column and
/// row of the same heights all round, as pixels reach half a cell beyond their samples; beyond that
/// there is the height `fill`, and so at missing samples. Round the world columns repeat instead.
/// The surface is bilinear between these.
class ExtendedRaster {
 public:
  static constexpr std::int64_t kMargin = 2;

  /// Of columns along longitudes and rows along latitudes; fails on others, and on latitudes beyond
  /// the poles, or more than once round. Rows that rounding put beyond a pole are put on it.
  [[nodiscard]] static Result<ExtendedRaster> of(const HeightFrame& frame, double fill);

  [[nodiscard]] std::int64_t n_rows() const { return n_rows_; }
  /// Different ones: round the world the last may be the first again.
  [[nodiscard]] std::int64_t n_columns() const { return n_columns_; }
  [[nodiscard]] std::int64_t n_stored_columns() const { return n_stored_; }
  [[nodiscard]] bool wraps() const { return wraps_; }
  [[nodiscard]] double fill() const { return fill_; }
  /// Of the samples, with half a cell all round.
  [[nodiscard]] DegreeBox box() const;
  /// Degrees between neighbours, the smaller of both directions.
  [[nodiscard]] double spacing() const;

  /// Longitude of a column of the turn: 0 is that of the frame, 1 is 360 degrees to the east.
  [[nodiscard]] double longitude(double column, int turn) const {
    return west_ + column * step_x_ + 360.0 * turn;
  }
  [[nodiscard]] double latitude(double row) const { return north_ + row * step_y_; }
  [[nodiscard]] double column(double longitude, int turn) const {
    return (longitude - 360.0 * turn - west_) / step_x_;
  }
  [[nodiscard]] double row(double latitude) const { return (latitude - north_) / step_y_; }

  /// Nothing where there is only the fill; of columns in the first turn that has it.
  [[nodiscard]] std::optional<Between> column_at(double longitude) const;
  [[nodiscard]] std::optional<Between> row_at(double latitude) const;

  /// Turns that may hold a part of the world between -180 and 180.
  static constexpr int kFirstTurn = -2;
  static constexpr int kLastTurn = 2;

  /// Columns in a turn, of those from `lowest` to n_columns() - 1 - `lowest`, that are between two
  /// longitudes; `beyond`: and so many more on either side.
  [[nodiscard]] IndexRange columns_between(double west, double east, int turn, std::int64_t lowest,
                                           std::int64_t beyond) const;
  [[nodiscard]] IndexRange rows_between(double south, double north, std::int64_t lowest,
                                        std::int64_t beyond) const;

 private:
  ExtendedRaster() = default;

  std::int64_t n_columns_ = 0, n_rows_ = 0, n_stored_ = 0;
  double west_ = 0, step_x_ = 1, north_ = 0, step_y_ = 1;
  double fill_ = 0;
  bool wraps_ = false;
};

/// Some rows of a raster in memory, with what it is continued by.
class RowStrip {
 public:
  explicit RowStrip(const ExtendedRaster& raster) : raster_(&raster) {}

  /// Reads what these rows need, which may be margins. Fails as reading does, on heights beyond
  /// kMostHeight, and where a last column that is the first again has other heights.
  [[nodiscard]] Result<void> read(HeightRows& rows, IndexRange wanted);

  /// Rows that height() may be asked for.
  [[nodiscard]] IndexRange rows() const { return rows_; }
  /// Also of margins and missing samples. column: from -kMargin to n_columns() - 1 + kMargin.
  [[nodiscard]] double height(std::int64_t column, std::int64_t row) const;
  /// Between four of these.
  [[nodiscard]] double surface(const Between& column, const Between& row) const {
    const auto along = [&](std::int64_t y) {
      return column.mix(height(column.first, y), height(column.first + 1, y));
    };
    return row.mix(along(row.first), along(row.first + 1));
  }
  /// Of a sample; NaN: missing.
  [[nodiscard]] double sample(std::int64_t column, std::int64_t row) const {
    return heights_[static_cast<std::size_t>((row - first_) * raster_->n_stored_columns() +
                                             column)];
  }

 private:
  [[nodiscard]] Result<void> check(const HeightRows& rows) const;

  const ExtendedRaster* raster_;
  IndexRange rows_;
  std::int64_t first_ = 0;  ///< Stored.
  std::vector<double> heights_;
};

}  // namespace lode::tile_pyramid
