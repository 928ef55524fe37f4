// Rasters that go round the earth, cut open.
#include "lode/api/round_terrain.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "lode/locate/polygon_locator.h"
#include "tests/terrain/hierarchy_fixtures.h"

namespace lode {
namespace {

HorizontalMetric degrees() {
  return {.is_known = true, .ellipsoid = kWgs84Ellipsoid, .angle_unit = std::numbers::pi / 180};
}

double globe_height(int x, int y) { return std::round(100 * std::sin(x * 1.7) + y); }

/// 36 columns of ten degrees, or one more, which is the first again.
HeightGrid globe(int n_columns, int n_turn = 36) {
  HeightGrid grid = test::make_grid<std::int16_t>(
      n_columns, 7, [&](int x, int y) { return globe_height(x % n_turn, y); });
  grid.to_world = {-180, 360.0 / n_turn, 0, 30, 0, -10};
  delaunay::test::set_missing(grid, 5, 3);
  if (n_columns > n_turn + 5) delaunay::test::set_missing(grid, n_turn + 5, 3);
  return grid;
}

TEST(round_terrain, knows_rasters_that_go_round) {
  EXPECT_EQ(columns_of_turn(globe(36), degrees()), 36);
  EXPECT_EQ(columns_of_turn(globe(37), degrees()), 36);
  EXPECT_EQ(columns_of_turn(globe(35), degrees()), std::nullopt);
  EXPECT_EQ(columns_of_turn(globe(38), degrees()), std::nullopt);
  EXPECT_EQ(columns_of_turn(globe(36), {}), std::nullopt) << "in a plane";
  HeightGrid other = globe(37);
  std::get<HeightGrid::Samples<std::int16_t>>(other.heights)[36] += 1;
  EXPECT_EQ(columns_of_turn(other, degrees()), std::nullopt) << "another last column";
  for (const std::size_t i : {2U, 4U}) {
    HeightGrid turned = globe(36);
    turned.to_world[i] = 1;
    EXPECT_EQ(columns_of_turn(turned, degrees()), std::nullopt);
  }
  HeightGrid westward = globe(36);
  westward.to_world[1] = -10;
  EXPECT_EQ(columns_of_turn(westward, degrees()), std::nullopt);
  HeightGrid narrow = globe(36);
  narrow.to_world[1] = 9.99;
  EXPECT_EQ(columns_of_turn(narrow, degrees()), std::nullopt);
}

TEST(round_terrain, has_each_height_where_it_was) {
  for (const int n_columns : {36, 37})
    for (const double longitude : {-180.0, -180.1, 0.0, 3.0, 9.999, 175.0, 180.0, 725.0, -1000.0}) {
      SCOPED_TRACE(testing::Message() << n_columns << ", " << longitude);
      const HeightGrid cut = cut_open_at(globe(n_columns), 36, longitude);
      ASSERT_EQ(cut.n_columns, 37);
      EXPECT_LE(cut.to_world[0], longitude);
      EXPECT_GT(cut.to_world[0] + 10, longitude);
      for (int y = 0; y < 7; ++y)
        for (int x = 0; x < 37; ++x) {
          const double at = cut.world(x, y)[0];
          const auto column = static_cast<int>(std::lround((at + 180) / 10) % 36 + 36) % 36;
          ASSERT_EQ(cut.has_height(x, y), !(column == 5 && y == 3));
          if (cut.has_height(x, y)) EXPECT_EQ(cut.height(x, y), globe_height(column, y));
        }
    }
}

TEST(round_terrain, leaves_alone_what_is_no_longitude) {
  EXPECT_TRUE(is_longitude(degrees(), -36000));
  for (const double far : {36001.0, -1e300, HUGE_VAL, std::nan("")}) {
    EXPECT_FALSE(is_longitude(degrees(), far));
    HeightGrid away = globe(36);
    away.to_world[0] = far;
    EXPECT_EQ(columns_of_turn(away, degrees()), std::nullopt);
    EXPECT_EQ(nearest_turn(degrees(), {{far, 3}}, {{1, 8}})[0], 1);
  }
  EXPECT_EQ(nearest_turn(degrees(), {{0, 3}}, {{1e300, 8}})[0], 1e300);
}

TEST(round_terrain, brings_places_near) {
  const auto near = [](double from, double to) {
    return nearest_turn(degrees(), {{from, 3}}, {{to, 8}});
  };
  EXPECT_NEAR(near(359, 1)[0], 361, 1e-9);
  EXPECT_NEAR(near(-170, 170)[0], -190, 1e-9);
  EXPECT_NEAR(near(10, 20)[0], 20, 1e-9);
  EXPECT_NEAR(near(10, 740)[0], 20, 1e-9);
  EXPECT_EQ(near(359, 1)[1], 8);
  EXPECT_EQ(nearest_turn({}, {{359, 3}}, {{1, 8}})[0], 1) << "in a plane";
}

TEST(round_terrain, adds_the_turns_that_bring_a_longitude_near) {
  const auto shift = [](double to, double longitude) {
    return turns_towards(degrees(), to, longitude);
  };
  EXPECT_NEAR(shift(250, -110), 360, 1e-9);
  EXPECT_NEAR(shift(-110, 250), -360, 1e-9);
  EXPECT_NEAR(shift(10, 740), -720, 1e-9);
  EXPECT_EQ(shift(10, -169), 0);
  EXPECT_EQ(shift(0, 180), 0) << "as near on both sides";
  EXPECT_EQ(shift(0, -180), 0);
  EXPECT_EQ(shift(-1e-12, 180), 0);
  EXPECT_EQ(shift(0, 1e300), 0);
  EXPECT_EQ(turns_towards({}, 250, -110), 0) << "in a plane";
  EXPECT_NEAR(middle_x(globe(37)), 0, 1e-12);
}

TEST(round_terrain, counts_longitudes_of_points_from_their_widest_gap) {
  const auto from = [](const std::vector<double>& longitudes, const HorizontalMetric& metric) {
    std::vector<Vec3d> points;
    for (const double x : longitudes) points.push_back({{x, 1, 2}});
    return turn_from(metric, points);
  };
  EXPECT_EQ(from({-178, 179, -180, 178, 180}, degrees()), 0);
  EXPECT_EQ(from({-170, -100, 150, 179}, degrees()), 25);
  EXPECT_EQ(from({10, 350, 2, 358}, degrees()), 180) << "of longitudes from 0 to 360";
  EXPECT_EQ(from({-130, -60, 20, 100}, degrees()), std::nullopt) << "the widest gap is outside";
  std::vector<double> all_round;
  for (int x = -180; x < 180; x += 5) all_round.push_back(x);
  EXPECT_EQ(from(all_round, degrees()), std::nullopt);
  EXPECT_EQ(from({-80, 80}, degrees()), std::nullopt);
  EXPECT_EQ(from({-178, 178}, {}), std::nullopt) << "in a plane";
  EXPECT_EQ(from({-178, 178, 900}, degrees()), std::nullopt) << "no longitudes";
  EXPECT_EQ(from({500000, 500001, 500250}, degrees()), std::nullopt) << "no longitudes";
  std::vector<Vec3d> points{{{-178, 1, 2}}, {{178, 3, 4}}};
  EXPECT_EQ(turn_places(degrees(), 0, points), 1U);
  EXPECT_NEAR(points[0][0], 182, 1e-12);
  EXPECT_EQ(points[1][0], 178);
}

TEST(round_terrain, takes_jumps_out_of_lines) {
  const auto unrolled = [](std::vector<double> longitudes, const HorizontalMetric& metric) {
    std::vector<Vec3d> line;
    for (const double x : longitudes) line.push_back({{x, 1, 2}});
    unroll(metric, line);
    std::vector<double> made;
    for (const Vec3d& p : line) made.push_back(std::round(p[0] * 1e9) / 1e9);
    return made;
  };
  using Line = std::vector<double>;
  EXPECT_EQ(unrolled({179, -179, -178, 179}, degrees()), (Line{179, 181, 182, 179}));
  EXPECT_EQ(unrolled({-179, 179}, degrees()), (Line{-179, -181}));
  EXPECT_EQ(unrolled({-90, 90, 0}, degrees()), (Line{-90, 90, 0})) << "half a turn is no jump";
  EXPECT_EQ(unrolled({10, 350, 20}, degrees()), (Line{10, -10, 20}));
  EXPECT_EQ(unrolled({179, -179}, {}), (Line{179, -179})) << "in a plane";
}

/// What of a turn from a longitude polygons cover at a latitude of 5, in degrees of 0.5.
std::vector<double> covered(const std::vector<PlacePolygon>& polygons, double from) {
  const PolygonLocator locator(polygons);
  std::vector<double> found;
  for (double x = from + 0.25; x < from + 360; x += 0.5)
    if (locator.holds({{x, 5}})) found.push_back(x);
  return found;
}

PlacePolygon box_from(double west, double east) {
  return {{{{west, 0}}, {{east, 0}}, {{east, 10}}, {{west, 10}}}};
}

TEST(round_terrain, turns_outlines_with_their_points) {
  const double from = 10;
  const auto turned = [&](std::vector<PlacePolygon> polygons) {
    return covered(turn_polygons(degrees(), from, std::move(polygons)), from);
  };
  const std::vector<double> expected = covered({box_from(178, 182)}, from);
  ASSERT_EQ(expected.size(), 8U);
  EXPECT_EQ(turned({box_from(178, 182)}), expected);
  EXPECT_EQ(turned({box_from(-182, -178)}), expected);
  EXPECT_EQ(turned({box_from(178, -178)}), expected) << "a ring that jumps";
  EXPECT_EQ(turned({box_from(178, 180), box_from(-180, -178)}), expected) << "in two parts";
  // 180 and -180 are one place.
  EXPECT_EQ(turned({{{{{178, 0}},
                      {{180, 0}},
                      {{-180, 0}},
                      {{-178, 0}},
                      {{-178, 10}},
                      {{-180, 10}},
                      {{180, 10}},
                      {{178, 10}}}}}),
            expected);
  // With a hole on the other side of the jump.
  PlacePolygon holed = box_from(178, -178);
  holed.push_back(box_from(-179.5, -179).front());
  std::vector<double> with_hole = expected;
  std::erase_if(with_hole, [](double x) { return x > 180.5 && x < 181; });
  EXPECT_EQ(turned({holed}), with_hole);
  // All the way round, and over where the turn begins.
  EXPECT_EQ(turned({box_from(-180, 180)}).size(), 720U);
  EXPECT_EQ(turned({box_from(-100, 60)}).size(), 320U);
  EXPECT_EQ(turned({box_from(0, 20)}), covered({box_from(0, 20), box_from(360, 380)}, from));
}

}  // namespace
}  // namespace lode
