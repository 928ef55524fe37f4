// Pictures of terrain: what is where, and in which colour.
#include "lode/api/terrain_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/terrain/height_grids.h"

namespace lode {
namespace {

/// Rows from north to south, a unit apart: x from 0, y down from 0.
HeightGrid grid_of(int n_columns, int n_rows, const std::function<double(int, int)>& height) {
  HeightGrid grid = test::float_grid(n_columns, n_rows, height);
  grid.to_world = {0, 1, 0, 0, 0, -1};
  return grid;
}

struct Drawn {
  Image image;
  TerrainPictureReport report;
};

Drawn drawn(const HeightGrid& grid, TerrainPictureOptions options,
            const HorizontalMetric& metric = {}) {
  options.render.width = 120;
  options.render.height = 120;
  Drawn made;
  Progress progress;
  auto image = draw_terrain(grid, metric, options, made.report, progress);
  EXPECT_TRUE(image) << (image ? "" : image.error().message);
  if (image) made.image = std::move(*image);
  return made;
}

TEST(terrain_picture, has_water_in_blue_land_in_green_and_north_up) {
  // Land in the north east alone.
  const HeightGrid grid = grid_of(
      61, 61, [](int x, int y) { return x > 30 && y < 30 ? 5.0 + 0.01 * x : -20.0 + 0.01 * y; });
  const Drawn made = drawn(grid, {.is_from_above = true, .render = {}});
  const auto is_blue = [&](int x, int y) {
    const Color& c = made.image.at(x, y);
    return c.b > c.r && c.b > c.g;
  };
  EXPECT_FALSE(is_blue(85, 35));
  EXPECT_TRUE(is_blue(35, 35));
  EXPECT_TRUE(is_blue(35, 85));
  EXPECT_TRUE(is_blue(85, 85));
  EXPECT_EQ(made.report.width, 60);
}

TEST(terrain_picture, exaggerates_as_it_takes_and_as_told) {
  const auto relief = [](double most) {
    return grid_of(41, 41, [=](int x, int) { return x * most / 40; });
  };
  EXPECT_EQ(drawn(relief(4), {.render = {}}).report.exaggeration, 1);
  EXPECT_EQ(drawn(relief(1), {.render = {}}).report.exaggeration, 5);
  EXPECT_EQ(drawn(relief(0.004), {.render = {}}).report.exaggeration, 1000);
  EXPECT_EQ(drawn(relief(0), {.render = {}}).report.exaggeration, 1);
  EXPECT_EQ(drawn(relief(4), {.exaggeration = 3.5, .render = {}}).report.exaggeration, 3.5);
  HeightGrid feet = relief(1);
  feet.vertical_unit = "US survey foot";
  EXPECT_EQ(drawn(feet, {.render = {}}).report.exaggeration, 10);
  // In a plane of feet heights are taken for feet where nothing says what they are.
  HorizontalMetric plane;
  plane.is_known = true;
  plane.length_unit = 0.3048;
  EXPECT_EQ(drawn(relief(1), {.render = {}}, plane).report.exaggeration, 5);
  EXPECT_FALSE(drawn(relief(1), {.render = {}}, plane).report.is_vertical_unit_known);
}

TEST(terrain_picture, counts_degrees_as_they_are_in_the_middle) {
  HeightGrid grid = grid_of(41, 41, [](int x, int) { return 10.0 * x; });
  grid.to_world = {10, 0.1, 0, 62, 0, -0.1};  // middle at 60 degrees north
  HorizontalMetric metric;
  metric.is_known = true;
  metric.ellipsoid = kWgs84Ellipsoid;
  metric.angle_unit = std::acos(-1.0) / 180;
  const TerrainPictureReport report = drawn(grid, {.render = {}}, metric).report;
  EXPECT_NEAR(report.width, 4 * 55'800, 100);
  EXPECT_NEAR(report.depth, 4 * 111'412, 100);
}

TEST(terrain_picture, has_contours_where_heights_are_multiples) {
  // Heights rise from west to east: lines run north, at x = 10, 20, ...
  const HeightGrid grid = grid_of(61, 61, [](int x, int) { return 0.1 * x; });
  const Drawn plain =
      drawn(grid, {.is_from_above = true, .render = {.color = Color{255, 255, 255}}});
  const Drawn lined = drawn(
      grid,
      {.contour_interval = 1, .is_from_above = true, .render = {.color = Color{255, 255, 255}}});
  EXPECT_EQ(lined.report.n_contours, 6U);  // 1 to 6; at 0 nothing is below
  int n_dark = 0;
  bool was_dark = false;
  for (int x = 0; x < 120; ++x) {
    const bool is_dark = lined.image.at(x, 60).g + 40 < plain.image.at(x, 60).g;
    n_dark += is_dark && !was_dark ? 1 : 0;
    was_dark = is_dark;
  }
  EXPECT_GE(n_dark, 5);
  EXPECT_LE(n_dark, 6);
}

TEST(terrain_picture, is_the_same_for_any_number_of_threads) {
  const HeightGrid grid =
      grid_of(50, 40, [](int x, int y) { return 3 * std::sin(0.3 * x) * std::cos(0.2 * y); });
  const Image one = drawn(grid, {.contour_interval = 0.5, .render = {.threads = {1}}}).image;
  EXPECT_EQ(one, drawn(grid, {.contour_interval = 0.5, .render = {.threads = {3}}}).image);
}

TEST(terrain_picture, refuses_what_cannot_be_drawn) {
  const HeightGrid grid = grid_of(9, 9, [](int x, int) { return x; });
  TerrainPictureReport report;
  Progress progress;
  const auto refused = [&](const HeightGrid& of, const TerrainPictureOptions& options) {
    const auto image = draw_terrain(of, {}, options, report, progress);
    return image ? std::string() : image.error().message;
  };
  EXPECT_NE(refused(grid, {.exaggeration = 0, .render = {}}).find("exaggeration"),
            std::string::npos);
  EXPECT_NE(refused(grid, {.contour_interval = -1, .render = {}}).find("interval > 0"),
            std::string::npos);
  EXPECT_NE(refused(grid, {.contour_interval = 1e-9, .render = {}}).find("fewer than"),
            std::string::npos);
  EXPECT_NE(refused(grid, {.contour_interval = 1e-320, .render = {}}).find("fewer than"),
            std::string::npos);
  EXPECT_NE(refused(grid, {.exaggeration = 1e-320, .render = {}}).find("exaggeration"),
            std::string::npos);
  HorizontalMetric metric;
  metric.ellipsoid = kWgs84Ellipsoid;
  metric.angle_unit = std::acos(-1.0) / 180;
  HeightGrid beyond = grid;
  beyond.to_world = {0, 1, 0, 1e7, 0, -1};
  const auto drawn_beyond = draw_terrain(beyond, metric, {.render = {}}, report, progress);
  ASSERT_FALSE(drawn_beyond);
  EXPECT_NE(drawn_beyond.error().message.find("latitudes from -90 to 90"), std::string::npos);
  HeightGrid none = grid;
  none.is_valid.assign(81, 0);
  EXPECT_NE(refused(none, {.render = {}}), "");
}

}  // namespace
}  // namespace lode
