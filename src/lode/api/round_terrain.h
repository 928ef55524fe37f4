#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "lode/core/height_frame.h"
#include "lode/core/height_grid.h"
#include "lode/core/horizontal_metric.h"
#include "lode/core/vec.h"

namespace lode {

/// Of longitudes, in their unit.
[[nodiscard]] double whole_turn(const HorizontalMetric& metric);

/// Whether a longitude, in the metric's unit, is one that turns mean something of: beyond a hundred
/// of them it is none, but a mistake.
[[nodiscard]] bool is_longitude(const HorizontalMetric& metric, double longitude);

/// Of a raster in longitudes that goes round the earth, how many columns go into a turn: its own,
/// or all but the last, where that is the first again and has its heights. Nothing of others, and
/// of rasters that are turned, run from east to west, or are nowhere on the earth.
[[nodiscard]] std::optional<std::int32_t> columns_of_turn(const HeightGrid& grid,
                                                          const HorizontalMetric& metric);

/// Such a raster from the column at a longitude (is_longitude()), or the next to its west, all the
/// way round to that column once more: so a way that begins there and is no longer than a turn does
/// not leave it.
[[nodiscard]] HeightGrid cut_open_at(const HeightGrid& grid, std::int32_t n_turn, double longitude);

/// Whole turns to be added to a longitude, so that it is no more than half a turn from another; 0
/// where that is so, and where either is none.
[[nodiscard]] double turns_towards(const HorizontalMetric& metric, double to, double longitude);

/// Where longitudes of points on both sides of where they jump (178 to 180 and -180 to -178) are to
/// be counted from: those west of it lie whole around the earth, once a turn is added to them. It
/// is the middle of the widest gap between them, where that is a quarter of a turn or more, and
/// wider than what is left around them. Nothing where they are best as they are, or are none. O(n
/// log n) where they are more than a half turn apart.
[[nodiscard]] std::optional<double> turn_from(const HorizontalMetric& metric,
                                              std::span<const Vec3d> points);

/// Adds a turn to x of places that lie west of `from`; how many there were.
template <typename Places>
std::uint64_t turn_places(const HorizontalMetric& metric, double from, Places& places) {
  std::uint64_t n = 0;
  for (auto& place : places) {
    if (!(place[0] < from)) continue;
    place[0] += whole_turn(metric);
    ++n;
  }
  return n;
}

/// The x of the middle of a terrain's columns and rows.
[[nodiscard]] double middle_x(const HeightFrame& frame);

/// A place as many turns on or back as bring it nearest to another; itself, where either is at no
/// longitude.
[[nodiscard]] Vec<double, 2> nearest_turn(const HorizontalMetric& metric,
                                          const Vec<double, 2>& from, Vec<double, 2> to);

}  // namespace lode
