#include "lode/models/terrain/tile_pyramid/extended_raster.h"

#include <algorithm>
#include <cmath>

namespace lode::tile_pyramid {
namespace {

/// Of a cell: what longitudes that are written in decimals may be off.
constexpr double kTolerance = 1e-3;

IndexRange between(double a, double b, std::int64_t beyond, IndexRange all) {
  const double from = std::min(a, b);
  const double to = std::max(a, b);
  // Of a sample on the border rounding must not decide.
  constexpr double kSlack = 1e-9;
  const auto low = static_cast<double>(all.first);
  const auto high = static_cast<double>(all.last);
  const double first =
      std::ceil(std::clamp(from - kSlack, low - 1, high + 1)) - static_cast<double>(beyond);
  const double last =
      std::floor(std::clamp(to + kSlack, low - 1, high + 1)) + static_cast<double>(beyond);
  return {std::max(all.first, static_cast<std::int64_t>(first)),
          std::min(all.last, static_cast<std::int64_t>(last))};
}

std::optional<Between> place_between(double index, std::int64_t n) {
  constexpr auto kBeyond = static_cast<double>(ExtendedRaster::kMargin);
  if (!(index > -kBeyond && index < static_cast<double>(n - 1) + kBeyond)) return std::nullopt;
  const double first = std::floor(index);
  return Between{static_cast<std::int64_t>(first), index - first};
}

/// Of one sample, known twice: both missing, or equal but for rounding in transformations.
bool is_same(double a, double b) {
  constexpr double kRounding = 1e-6;  // metres
  return std::isnan(a) ? std::isnan(b) : std::abs(a - b) <= kRounding;
}

}  // namespace

Result<ExtendedRaster> ExtendedRaster::of(const HeightFrame& frame, double fill) {
  const auto& g = frame.to_world;
  if (g[2] != 0 || g[4] != 0 || !(g[1] != 0) || !(g[5] != 0))
    return fail("expected columns along longitudes and rows along latitudes, got a raster turned");
  ExtendedRaster raster;
  raster.n_stored_ = frame.n_columns;
  raster.n_rows_ = frame.n_rows;
  raster.west_ = g[0];
  raster.step_x_ = g[1];
  raster.north_ = g[3];
  raster.step_y_ = g[5];
  raster.fill_ = fill;
  const double round = 360 / std::abs(g[1]);
  const double whole = std::round(round);
  raster.wraps_ = std::abs(round - whole) * std::abs(g[1]) <= kTolerance * std::abs(g[1]) &&
                  static_cast<double>(frame.n_columns) >= whole;
  raster.n_columns_ = raster.wraps_ ? static_cast<std::int64_t>(whole) : frame.n_columns;
  if (static_cast<double>(frame.n_columns) > whole + 1)
    return fail("expected longitudes once round the world, got {} columns of {} degrees",
                frame.n_columns, std::abs(g[1]));
  const double last = raster.latitude(static_cast<double>(frame.n_rows - 1));
  const double slack = kTolerance * std::abs(g[5]);
  if (std::max(std::abs(g[3]), std::abs(last)) > 90 + slack)
    return fail("expected latitudes from -90 to 90 degrees, got samples from {} to {}{}", g[3],
                last,
                frame.crs.empty() ? " in a raster that says no CRS: with --crs and --resample one "
                                    "that is projected is put in degrees"
                                  : "");
  raster.north_ = std::clamp(g[3], -90.0, 90.0);
  if (frame.n_rows > 1)
    raster.step_y_ = (std::clamp(last, -90.0, 90.0) - raster.north_) / (frame.n_rows - 1);
  if (!(std::abs(g[0]) <= 360))
    return fail("expected a first longitude from -360 to 360 degrees, got {}", g[0]);
  return raster;
}

DegreeBox ExtendedRaster::box() const {
  const auto [west, east] =
      std::minmax({longitude(-0.5, 0), longitude(static_cast<double>(n_columns_) - 0.5, 0)});
  const auto [south, north] =
      std::minmax({latitude(-0.5), latitude(static_cast<double>(n_rows_) - 0.5)});
  return {west, std::max(-90.0, south), east, std::min(90.0, north)};
}

double ExtendedRaster::spacing() const { return std::min(std::abs(step_x_), std::abs(step_y_)); }

IndexRange ExtendedRaster::columns_between(double west, double east, int turn, std::int64_t lowest,
                                           std::int64_t beyond) const {
  return between(column(west, turn), column(east, turn), beyond, {lowest, n_columns_ - 1 - lowest});
}

IndexRange ExtendedRaster::rows_between(double south, double north, std::int64_t lowest,
                                        std::int64_t beyond) const {
  return between(row(south), row(north), beyond, {lowest, n_rows_ - 1 - lowest});
}

std::optional<Between> ExtendedRaster::column_at(double longitude) const {
  std::optional<Between> margin;
  for (int turn = kFirstTurn; turn <= kLastTurn; ++turn) {
    const auto found = place_between(column(longitude, turn), n_columns_);
    if (!found) continue;
    const bool is_inside = found->first >= 0 && (wraps_ || found->first + 1 < n_columns_);
    if (is_inside) return found;
    if (!margin) margin = found;
  }
  return margin;
}

std::optional<Between> ExtendedRaster::row_at(double latitude) const {
  return place_between(row(latitude), n_rows_);
}

Result<void> RowStrip::read(HeightRows& rows, IndexRange wanted) {
  rows_ = wanted;
  first_ = std::clamp<std::int64_t>(wanted.first, 0, raster_->n_rows() - 1);
  const std::int64_t last = std::clamp<std::int64_t>(wanted.last, 0, raster_->n_rows() - 1);
  if (wanted.is_empty()) return {};
  const std::int64_t n = last - first_ + 1;
  heights_.resize(static_cast<std::size_t>(n * raster_->n_stored_columns()));
  LODE_CHECK(rows.read(static_cast<std::int32_t>(first_), static_cast<std::int32_t>(n), heights_));
  return check(rows);
}

Result<void> RowStrip::check(const HeightRows& rows) const {
  const std::int64_t n_stored = raster_->n_stored_columns();
  const auto wrong =
      std::ranges::find_if(heights_, [](double z) { return std::abs(z) > kMostHeight; });
  if (wrong != heights_.end()) {
    const std::int64_t at = wrong - heights_.begin();
    return fail(
        "{}: expected heights of at most {} m, got {} in column {} of row {}: --nodata tells which "
        "value stands for missing samples",
        rows.name(), kMostHeight, *wrong, at % n_stored, first_ + at / n_stored);
  }
  if (n_stored == raster_->n_columns()) return {};
  const std::int64_t last = n_stored - 1;
  for (std::size_t at = 0; at < heights_.size(); at += static_cast<std::size_t>(n_stored)) {
    const double west = heights_[at];
    const double east = heights_[at + static_cast<std::size_t>(last)];
    if (!is_same(west, east))
      return fail(
          "{}: expected the last column, once round the world, to be the first again, got {} and "
          "{} in row {}: leave one out, for example by gdal_translate -srcwin",
          rows.name(), east, west, first_ + static_cast<std::int64_t>(at) / n_stored);
  }
  return {};
}

double RowStrip::height(std::int64_t column, std::int64_t row) const {
  const std::int64_t n = raster_->n_columns();
  if (raster_->wraps()) {
    column = (column + n) % n;
  } else {
    if (column < -1 || column > n) return raster_->fill();
    column = std::clamp<std::int64_t>(column, 0, n - 1);
  }
  if (row < -1 || row > raster_->n_rows()) return raster_->fill();
  const double found = sample(column, std::clamp<std::int64_t>(row, 0, raster_->n_rows() - 1));
  return std::isnan(found) ? raster_->fill() : found;
}

}  // namespace lode::tile_pyramid
