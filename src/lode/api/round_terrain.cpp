#include "lode/api/round_terrain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <type_traits>
#include <utility>
#include <vector>

namespace lode {
namespace {

/// The first row in which two columns have not the same height; nothing where they have everywhere.
std::optional<std::int32_t> first_row_of_others(const HeightGrid& grid, std::int32_t a,
                                                std::int32_t b) {
  for (std::int32_t y = 0; y < grid.n_rows; ++y) {
    const bool is_there = grid.has_height(a, y);
    if (is_there != grid.has_height(b, y)) return y;
    if (is_there && grid.height(a, y) != grid.height(b, y)) return y;
  }
  return std::nullopt;
}

/// How many columns from west to east go into a turn; 0 where it is no whole number, or there are
/// none.
double steps_of_turn(const HeightFrame& frame, const HorizontalMetric& metric) {
  const std::array<double, 6>& g = frame.to_world;
  if (!metric.ellipsoid || g[2] != 0 || g[4] != 0 || !(g[1] > 0)) return 0;
  if (!is_longitude(metric, g[0])) return 0;
  const double n = std::round(whole_turn(metric) / g[1]);
  constexpr double kSteps = 1e-3;  // That the seam may differ from others by.
  return n >= 3 && std::abs(n * g[1] - whole_turn(metric)) <= kSteps * g[1] ? n : 0;
}

/// The same of a raster with as many columns, or one more; nothing of others.
std::optional<std::int32_t> columns_in_turn(const HeightGrid& grid,
                                            const HorizontalMetric& metric) {
  const double n = steps_of_turn(grid, metric);
  if (n == 0 || (grid.n_columns != n && grid.n_columns != n + 1)) return std::nullopt;
  return static_cast<std::int32_t>(n);
}

}  // namespace

double whole_turn(const HorizontalMetric& metric) {
  return 2 * std::numbers::pi / metric.angle_unit;
}

bool is_longitude(const HorizontalMetric& metric, double longitude) {
  constexpr double kMostTurns = 100;
  return std::abs(longitude) <= kMostTurns * whole_turn(metric);
}

std::optional<std::int32_t> columns_of_turn(const HeightGrid& grid,
                                            const HorizontalMetric& metric) {
  const auto n = columns_in_turn(grid, metric);
  if (!n || first_row_apart(grid, metric)) return std::nullopt;
  return n;
}

std::optional<std::int32_t> first_row_apart(const HeightGrid& grid,
                                            const HorizontalMetric& metric) {
  const auto n = columns_in_turn(grid, metric);
  if (!n || grid.n_columns == *n) return std::nullopt;
  return first_row_of_others(grid, 0, grid.n_columns - 1);
}

std::int32_t columns_between_turns(const HeightFrame& frame, const HorizontalMetric& metric) {
  return frame.n_columns - 1 == steps_of_turn(frame, metric) ? frame.n_columns - 1 : 0;
}

HeightGrid cut_open_at(const HeightGrid& grid, std::int32_t n_turn, double longitude) {
  const double step = grid.to_world[1];
  const double steps = std::floor((longitude - grid.to_world[0]) / step);
  const auto first = static_cast<std::int32_t>(steps - std::floor(steps / n_turn) * n_turn);
  const auto column = [&](std::int32_t x) { return (first + x) % n_turn; };
  return std::visit(
      [&](const auto& from) {
        using T = std::remove_cvref_t<decltype(from[0])>;
        HeightGrid cut = make_height_grid<T>(n_turn + 1, grid.n_rows);
        cut.crs = grid.crs;
        cut.vertical_unit = grid.vertical_unit;
        cut.to_world = grid.to_world;
        cut.to_world[0] += steps * step;
        cut.is_round = true;
        auto& to = std::get<HeightGrid::Samples<T>>(cut.heights);
        if (!grid.is_valid.empty()) cut.is_valid.resize(static_cast<std::size_t>(cut.n_samples()));
        for (std::int32_t y = 0; y < grid.n_rows; ++y)
          for (std::int32_t x = 0; x <= n_turn; ++x) {
            to[static_cast<std::size_t>(y * cut.stride + x)] =
                from[static_cast<std::size_t>(y * grid.stride + column(x))];
            if (!grid.is_valid.empty())
              cut.is_valid[static_cast<std::size_t>(std::int64_t{y} * cut.n_columns + x)] =
                  grid.has_height(column(x), y) ? 1 : 0;
          }
        return cut;
      },
      grid.heights);
}

double turns_towards(const HorizontalMetric& metric, double to, double longitude) {
  if (!metric.ellipsoid || !is_longitude(metric, to) || !is_longitude(metric, longitude)) return 0;
  const double turns = (to - longitude) / whole_turn(metric);
  // What is half a turn away, but for rounding, is at the border of what goes all the way round.
  constexpr double kHalf = 0.5 + 1e-9;
  return std::copysign(std::max(0.0, std::ceil(std::abs(turns) - kHalf)), turns) *
         whole_turn(metric);
}

std::optional<double> turn_from(const HorizontalMetric& metric, std::span<const Vec3d> points) {
  if (!metric.ellipsoid || points.empty()) return std::nullopt;
  const double turn = whole_turn(metric);
  const auto [west, east] =
      std::ranges::minmax(points, {}, [](const Vec3d& point) { return point[0]; });
  if (!is_longitude(metric, west[0]) || !is_longitude(metric, east[0])) return std::nullopt;
  const double extent = east[0] - west[0];
  if (extent <= turn / 2 || extent > turn * (1 + 1e-9)) return std::nullopt;
  std::vector<double> longitudes;
  longitudes.reserve(points.size());
  for (const Vec3d& point : points) longitudes.push_back(point[0]);
  std::ranges::sort(longitudes);
  double widest = std::max(turn / 4, turn - extent);
  std::optional<double> from;
  for (std::size_t i = 1; i < longitudes.size(); ++i) {
    const double gap = longitudes[i] - longitudes[i - 1];
    if (gap <= widest) continue;
    widest = gap;
    from = longitudes[i - 1] + gap / 2;
  }
  return from;
}

namespace {

struct Longitudes {
  double west = 0;
  double east = 0;
};

Longitudes longitudes_of(std::span<const Vec<double, 2>> ring) {
  const auto [west, east] =
      std::ranges::minmax(ring, {}, [](const Vec<double, 2>& place) { return place[0]; });
  return {west[0], east[0]};
}

void shift(PlacePolygon& polygon, double by) {
  for (auto& ring : polygon)
    for (auto& place : ring) place[0] += by;
}

}  // namespace

void unroll_polygon(const HorizontalMetric& metric, PlacePolygon& polygon) {
  if (!metric.ellipsoid || polygon.empty() || polygon.front().empty()) return;
  PlacePolygon unrolled = polygon;
  unroll(metric, unrolled.front());
  const auto [west, east] = longitudes_of(unrolled.front());
  constexpr double kHalf = 0.5 + 1e-9;
  if (!(east > west && east - west <= kHalf * whole_turn(metric))) return;
  for (std::size_t i = 1; i < unrolled.size(); ++i) {
    if (unrolled[i].empty()) continue;
    unroll(metric, unrolled[i]);
    const auto [hole_west, hole_east] = longitudes_of(unrolled[i]);
    const double shift = turns_towards(metric, (west + east) / 2, (hole_west + hole_east) / 2);
    for (auto& place : unrolled[i]) place[0] += shift;
  }
  polygon = std::move(unrolled);
}

std::vector<PlacePolygon> turn_polygons(const HorizontalMetric& metric, double from,
                                        std::vector<PlacePolygon> polygons) {
  const double turn = whole_turn(metric);
  std::vector<PlacePolygon> turned;
  for (PlacePolygon& polygon : polygons) {
    // Those without corners are for others to refuse.
    if (polygon.empty() || polygon.front().empty()) {
      turned.push_back(std::move(polygon));
      continue;
    }
    unroll_polygon(metric, polygon);
    const double west = longitudes_of(polygon.front()).west;
    if (is_longitude(metric, west)) shift(polygon, turn * std::ceil((from - west) / turn));
    // What is now behind the turn's end lies before its beginning, too.
    if (longitudes_of(polygon.front()).east > from + turn) {
      shift(turned.emplace_back(polygon), -turn);
    }
    turned.push_back(std::move(polygon));
  }
  return turned;
}

double middle_x(const HeightFrame& frame) {
  return frame.world((frame.n_columns - 1) / 2.0, (frame.n_rows - 1) / 2.0)[0];
}

Vec<double, 2> nearest_turn(const HorizontalMetric& metric, const Vec<double, 2>& from,
                            Vec<double, 2> to) {
  if (!metric.ellipsoid || !is_longitude(metric, from[0]) || !is_longitude(metric, to[0]))
    return to;
  const double turn = whole_turn(metric);
  to[0] += turn * std::round((from[0] - to[0]) / turn);
  return to;
}

}  // namespace lode
