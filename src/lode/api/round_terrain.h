#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/height_grid.h"
#include "lode/core/horizontal_metric.h"
#include "lode/core/place_polygon.h"
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

/// Of a raster that were one, if its last column had the heights of the first, in whose place it
/// is: the first row where it has not.
[[nodiscard]] std::optional<std::int32_t> first_row_apart(const HeightGrid& grid,
                                                          const HorizontalMetric& metric);

/// Columns from a terrain's first to its last, where these are a whole turn apart and so one place;
/// else 0.
[[nodiscard]] std::int32_t columns_between_turns(const HeightFrame& frame,
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

/// Takes jumps out of the longitudes of places along a line or ring: each is as many turns on or
/// back as bring it to half a turn or less from the one before.
template <typename Places>
void unroll(const HorizontalMetric& metric, Places& places) {
  for (std::size_t i = 1; i < places.size(); ++i)
    places[i][0] += turns_towards(metric, places[i - 1][0], places[i][0]);
}

/// Takes jumps out of a polygon's rings, where that leaves it half a turn wide or less, and brings
/// its holes into it; else, and without longitudes, it stays as it is.
void unroll_polygon(const HorizontalMetric& metric, PlacePolygon& polygon);

/// Polygons for places that were turned (turn_places()): whole turns on or back, so that each
/// covers what it does of the turn that begins at `from`, twice where it reaches over both ends.
/// Rings that jump (from 179 to -179) go the shorter way, where that leaves them half a turn wide
/// or less; else, as those of the whole earth, they are as they are.
[[nodiscard]] std::vector<PlacePolygon> turn_polygons(const HorizontalMetric& metric, double from,
                                                      std::vector<PlacePolygon> polygons);

/// The x of the middle of a terrain's columns and rows.
[[nodiscard]] double middle_x(const HeightFrame& frame);

/// A place as many turns on or back as bring it nearest to another; itself, where either is at no
/// longitude.
[[nodiscard]] Vec<double, 2> nearest_turn(const HorizontalMetric& metric,
                                          const Vec<double, 2>& from, Vec<double, 2> to);

}  // namespace lode
