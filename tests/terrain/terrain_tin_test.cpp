#include "lode/api/terrain_tin.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lode/api/files.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode {
namespace {

using delaunay::test::make_grid;
using delaunay::test::set_missing;

double waves(std::int32_t x, std::int32_t y) {
  return std::round(800 * std::sin(0.17 * x) * std::cos(0.13 * y) + 30 * std::sin(1.3 * x + y));
}

HeightGrid metre_grid() {
  HeightGrid grid = make_grid<std::int16_t>(50, 40, waves);
  grid.to_world = {500000.25, 30, 0, 4000000.5, 0, -30};
  return grid;
}

TerrainTin select(const HeightGrid& grid, double max_error, const HorizontalMetric& metric = {}) {
  Progress progress;
  auto tin = TerrainTin::select(grid, {.max_error = max_error}, metric, progress);
  if (!tin) ADD_FAILURE() << tin.error().message;
  return std::move(tin).value();
}

TEST(terrain_tin, has_heights_within_their_bounds_at_all_samples) {
  HeightGrid grid = metre_grid();
  for (std::int32_t i = 0; i < 7; ++i) set_missing(grid, 20 + i % 3, 11 + i % 2);
  std::vector<Place> places;
  for (std::int32_t y = 0; y < 40; ++y)
    for (std::int32_t x = 0; x < 50; ++x) places.push_back(grid.world(x, y));
  for (const double max_error : {0.0, 20.0, 500.0}) {
    const TerrainTin tin = select(grid, max_error);
    std::vector<TerrainHeight> heights;
    Progress progress;
    const auto report = tin.heights(places, heights, {2}, progress);
    ASSERT_TRUE(report);
    EXPECT_EQ(report->n_outside, 0U);
    EXPECT_GT(report->n_in_gaps, 0U);
    for (std::int32_t y = 0; y < 40; ++y)
      for (std::int32_t x = 0; x < 50; ++x) {
        const TerrainHeight& z = heights[static_cast<std::size_t>(50 * y + x)];
        if (z.where != TerrainHeight::Where::inside) {
          EXPECT_FALSE(grid.has_height(x, y) && x > 23);
          continue;
        }
        EXPECT_LE(std::abs(z.height - waves(x, y)), z.bound);
        EXPECT_LE(z.bound, tin.report().achieved_error + 1e-9);
        if (max_error == 0) EXPECT_EQ(z.height, waves(x, y));
      }
  }
}

TEST(terrain_tin, has_the_same_heights_for_any_number_of_threads) {
  const HeightGrid grid = metre_grid();
  const TerrainTin tin = select(grid, 20);
  std::vector<Place> places;
  for (int i = 0; i < 20000; ++i)
    places.push_back(grid.world(std::fmod(i * 0.377, 51) - 1, std::fmod(i * 0.731, 41) - 1));
  std::vector<TerrainHeight> one;
  std::vector<TerrainHeight> four;
  Progress progress;
  ASSERT_TRUE(tin.heights(places, one, {1}, progress));
  ASSERT_TRUE(tin.heights(places, four, {4}, progress));
  for (std::size_t i = 0; i < places.size(); ++i) {
    ASSERT_EQ(one[i].where, four[i].where);
    ASSERT_EQ(one[i].height, four[i].height);
    ASSERT_EQ(one[i].bound, four[i].bound);
  }
}

TEST(terrain_tin, takes_longitudes_that_differ_by_a_turn_for_one) {
  HeightGrid grid = make_grid<std::int16_t>(50, 40, waves);
  grid.to_world = {200, 1, 0, 30, 0, -1};
  const HorizontalMetric degrees{
      .is_known = true, .ellipsoid = kWgs84Ellipsoid, .angle_unit = std::acos(-1.0) / 180};
  const std::vector<Place> places{
      {{210.5, 20.25}}, {{-149.5, 20.25}}, {{570.5, 20.25}}, {{-160.5, 20.25}}};
  std::vector<TerrainHeight> heights;
  Progress progress;
  ASSERT_TRUE(select(grid, 20, degrees).heights(places, heights, {1}, progress));
  EXPECT_EQ(heights[0].where, TerrainHeight::Where::inside);
  EXPECT_EQ(heights[1].height, heights[0].height);
  EXPECT_EQ(heights[2].height, heights[0].height);
  EXPECT_EQ(heights[3].where, TerrainHeight::Where::outside);
  ASSERT_TRUE(select(grid, 20).heights(places, heights, {1}, progress));
  EXPECT_EQ(heights[1].where, TerrainHeight::Where::outside);
}

TEST(terrain_tin, measures_profiles_in_the_plane_and_tells_their_gaps) {
  HeightGrid grid = metre_grid();
  for (std::int32_t y = 10; y < 20; ++y)
    for (std::int32_t x = 20; x < 30; ++x) set_missing(grid, x, y);
  const TerrainTin tin = select(grid, 20);
  Progress progress;
  const Place from = grid.world(-10, 15);
  const Place to = grid.world(49, 15);
  const auto profile = tin.profile(from, to, progress);
  ASSERT_TRUE(profile);
  EXPECT_DOUBLE_EQ(profile->length, 59 * 30);
  ASSERT_EQ(profile->gaps.size(), 2U);
  EXPECT_DOUBLE_EQ(profile->gaps[0].begin, 0);
  EXPECT_DOUBLE_EQ(profile->gaps[0].end, 300);
  EXPECT_DOUBLE_EQ(profile->gaps[1].begin, 29 * 30);
  EXPECT_DOUBLE_EQ(profile->gaps[1].end, 40 * 30);
  EXPECT_EQ(profile->points.front().part, 1U);
  EXPECT_EQ(profile->points.back().part, 2U);
  EXPECT_EQ(profile->points.back().at, to);
  for (const TerrainProfile::Point& point : profile->points) {
    EXPECT_NEAR(point.distance, length(point.at - from), 1e-6);
    EXPECT_NEAR(point.at[1], from[1], 1e-9);
  }
  EXPECT_FALSE(tin.profile(from, {{std::nextafter(from[0], 0.0), from[1]}}, progress));
}

TEST(terrain_tin, measures_profiles_on_the_ellipsoid) {
  HeightGrid grid = make_grid<std::int16_t>(50, 40, waves);
  grid.to_world = {10, 0.1, 0, 50, 0, -0.1};
  const HorizontalMetric degrees{
      .is_known = true, .ellipsoid = kWgs84Ellipsoid, .angle_unit = std::acos(-1.0) / 180};
  Progress progress;
  const auto profile = select(grid, 20, degrees).profile({{10.5, 49.5}}, {{14.5, 47.5}}, progress);
  ASSERT_TRUE(profile);
  const double whole = degrees.distance({{10.5, 49.5}}, {{14.5, 47.5}});
  EXPECT_NEAR(profile->length / whole, 1, 1e-12);
  EXPECT_TRUE(profile->gaps.empty());
  double last = -1;
  for (const TerrainProfile::Point& point : profile->points) {
    EXPECT_GE(point.distance, last);
    EXPECT_NEAR(point.distance, degrees.distance({{10.5, 49.5}}, point.at), 1e-6);
    last = point.distance;
  }
}

TEST(terrain_tin, has_centimetres_at_heights_of_1e9) {
  HeightGrid grid = make_grid<double>(
      30, 20, [](std::int32_t x, std::int32_t y) { return 1e9 + 0.01 * waves(x, y); });
  std::vector<Place> places;
  for (std::int32_t y = 0; y < 20; ++y)
    for (std::int32_t x = 0; x < 30; ++x) places.push_back(grid.world(x, y));
  for (const double max_error : {0.0, 0.05}) {
    std::vector<TerrainHeight> heights;
    Progress progress;
    ASSERT_TRUE(select(grid, max_error).heights(places, heights, {1}, progress));
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double z =
          grid.height(static_cast<std::int32_t>(i) % 30, static_cast<std::int32_t>(i) / 30);
      EXPECT_LE(std::abs(heights[i].height - z), heights[i].bound);
      EXPECT_LE(heights[i].bound, max_error + 1e-5) << "half units of 1e9, and of slivers";
    }
  }
}

TEST(terrain_tin, stops_when_cancelled_and_refuses_grids_without_area) {
  const HeightGrid grid = metre_grid();
  const TerrainTin tin = select(grid, 20);
  Progress cancelled;
  cancelled.cancel();
  std::vector<TerrainHeight> heights;
  const std::vector<Place> places(10, grid.world(3, 3));
  EXPECT_FALSE(tin.heights(places, heights, {1}, cancelled));
  EXPECT_FALSE(tin.profile(places[0], grid.world(9, 9), cancelled));
  Progress progress;
  EXPECT_FALSE(TerrainTin::select(make_grid<float>(1, 1, waves), {}, {}, progress));
  EXPECT_FALSE(TerrainTin::select(make_grid<float>(1, 9, waves), {.max_error = 0}, {}, progress));
}

}  // namespace
}  // namespace lode
