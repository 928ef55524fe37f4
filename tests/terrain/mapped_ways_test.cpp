// Distances and lines in another CRS.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "lode/api/files.h"
#include "tests/terrain/mapped_fixtures.h"

namespace lode {
namespace {

using test::degree_grid;
using test::FunctionMap;
using test::open_target;
using test::to_utm;

/// On a sphere of radius 1 seen from a pole: radii and angles.
Place to_disc(const Place& p) { return {{p[1] * std::cos(p[0]), p[1] * std::sin(p[0])}}; }

TEST(mapped_distance, is_along_what_a_segment_becomes) {
  HorizontalMetric metric{.is_known = true};
  metric.elsewhere = std::make_shared<const HorizontalMetric>(
      HorizontalMetric{.is_known = true, .length_unit = 0.5, .unit = "half"});
  metric.map = std::make_shared<const FunctionMap>(to_disc);
  EXPECT_NEAR(metric.distance({{0.1, 3}}, {{2.6, 3}}), 7.5, 1e-9) << "an arc";
  EXPECT_NEAR(metric.distance({{0.1, 3}}, {{0.1, 5}}), 2, 1e-12) << "a ray";
  // Archimedes' spiral r = a from 0 to a: (a sqrt(1 + a^2) + asinh(a)) / 2.
  EXPECT_NEAR(metric.distance({{0, 0}}, {{2, 2}}), (2 * std::sqrt(5) + std::asinh(2)) / 2, 1e-9);
  EXPECT_EQ(metric.metres(), 0.5);
  metric.map = std::make_shared<const FunctionMap>([](const Place&) { return Place{{NAN, NAN}}; });
  EXPECT_TRUE(std::isnan(metric.distance({{0, 0}}, {{2, 2}})));
}

TEST(mapped_distance, is_none_where_the_map_jumps) {
  HorizontalMetric metric{.is_known = true};
  metric.elsewhere = std::make_shared<const HorizontalMetric>(HorizontalMetric{.is_known = true});
  for (const double jump : {0.5, 20.0, 4e7}) {
    metric.map = std::make_shared<const FunctionMap>([&](const Place& p) {
      return Place{{p[0] + (p[0] > 0.3 ? jump : 0), p[1]}};
    });
    EXPECT_TRUE(std::isnan(metric.distance({{-2, 0}}, {{2, 1}}))) << jump;
    EXPECT_NEAR(metric.distance({{-2, 0}}, {{0.25, 1}}), std::hypot(2.25, 1), 1e-12) << jump;
  }
  // Places that are one but for rounding.
  metric.map = std::make_shared<const FunctionMap>([&](const Place& p) {
    return Place{{p[0] + 1e-9 * std::sin(1e9 * p[0]), p[1]}};
  });
  EXPECT_NEAR(metric.distance({{1, 0}}, {{1 + 1e-9, 0}}), 1e-9, 1e-6);
  // Mercator's scale grows without bound, but does not jump.
  const TargetCrs mercator = open_target("EPSG:4326", "EPSG:3857");
  HorizontalMetric degrees{
      .is_known = true, .ellipsoid = kWgs84Ellipsoid, .angle_unit = std::numbers::pi / 180};
  degrees.elsewhere = std::make_shared<const HorizontalMetric>(mercator.metric);
  degrees.map = mercator.map;
  const double radius = kWgs84Ellipsoid.semi_major;
  const double north = radius * std::asinh(std::tan(89.5 * std::numbers::pi / 180));
  EXPECT_NEAR(degrees.distance({{10, 0}}, {{10, 89.5}}), north, 1e-3);
  EXPECT_NEAR(degrees.distance({{10, 50}}, {{10.001, 50}}), radius * 0.001 * std::numbers::pi / 180,
              1e-6);
}

TEST(mapped_distance, crosses_where_longitudes_jump) {
  HorizontalMetric metric{.is_known = true};
  HorizontalMetric degrees{
      .is_known = true, .ellipsoid = kWgs84Ellipsoid, .angle_unit = std::numbers::pi / 180};
  metric.elsewhere = std::make_shared<const HorizontalMetric>(degrees);
  metric.map = std::make_shared<const FunctionMap>([](const Place& p) {
    return Place{{std::remainder(p[0], 360), p[1]}};
  });
  const Place from{{179, 10}};
  const Place to{{183, 12}};
  EXPECT_NEAR(metric.distance(from, to), degrees.distance(from, to), 1e-6);
}

TEST(mapped_profile, has_distances_of_the_plane_it_is_measured_in) {
  const auto grid = degree_grid();
  const TargetCrs utm = open_target("EPSG:4326", "EPSG:32632");
  const auto read = read_metric(grid->crs);
  ASSERT_TRUE(read);
  HorizontalMetric metric = *read;
  metric.elsewhere = std::make_shared<const HorizontalMetric>(utm.metric);
  metric.map = utm.map;
  Progress progress;
  const auto tin = TerrainTin::select(Terrain(grid), {.max_error = 40}, metric, progress);
  ASSERT_TRUE(tin);
  const Place from{{7.05, 46.9}};
  const Place to{{8.1, 46.1}};
  const auto profile = tin->profile(from, to, progress);
  ASSERT_TRUE(profile);
  // Chords of 5 m err by less than a part in 10^9.
  constexpr int kChords = 20000;
  double length = 0;
  std::size_t row = 0;
  Place last = to_utm(from, 9);
  for (int i = 1; i <= kChords; ++i) {
    const double t = static_cast<double>(i) / kChords;
    const Place at = from * (1 - t) + to * t;
    const Place mapped = to_utm(at, 9);
    const double step = std::hypot(mapped[0] - last[0], mapped[1] - last[1]);
    // Rows within the step.
    while (row < profile->points.size() && profile->points[row].at[0] <= at[0]) {
      const Place here = to_utm(profile->points[row].at, 9);
      const double share = std::hypot(here[0] - last[0], here[1] - last[1]);
      ASSERT_NEAR(profile->points[row].distance, length + share, 1e-3);
      ++row;
    }
    length += step;
    last = mapped;
  }
  EXPECT_GE(row + 1, profile->points.size());
  EXPECT_NEAR(profile->length, length, 1e-3);
  EXPECT_GT(profile->points.size(), 20U);
  EXPECT_GT(std::abs(profile->length - read->distance(from, to)), 1) << "not the ellipsoid's";
}

TEST(mapped_lines, are_put_elsewhere_and_say_how_they_bend) {
  const FunctionMap bent(bend);
  std::vector<Place> line;
  for (int i = 0; i < 50; ++i) line.push_back({{7 + 0.02 * i, 46.2 + 0.01 * i}});
  std::vector<Place> single{line[3]};
  std::vector<Place> none;
  const std::vector<Place> before = line;
  const std::vector<std::span<Place>> all{line, single, none};
  Progress progress;
  const auto most = map_lines(all, bent, "other", progress);
  ASSERT_TRUE(most);
  double wanted = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    EXPECT_EQ(line[i], bend(before[i]));
    if (i == 0) continue;
    const Place middle = bend((before[i - 1] + before[i]) * 0.5);
    wanted = std::max(wanted, length(middle - (line[i - 1] + line[i]) * 0.5));
  }
  EXPECT_EQ(single[0], bend(before[3]));
  EXPECT_NEAR(*most, wanted, 1e-15);
  const FunctionMap torn([](const Place& p) { return Place{{p[0] < 7.51 ? p[0] : p[0] - 20, 3}}; });
  line = before;
  const auto over = map_lines(all, torn, "other", progress);
  ASSERT_FALSE(over);
  EXPECT_NE(over.error().message.find("seam"), std::string::npos) << over.error().message;
}

}  // namespace
}  // namespace lode
