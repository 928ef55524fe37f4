#include "lode/api/terrain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "lode/api/point_terrain.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode {
namespace {

using delaunay::test::make_grid;
using delaunay::test::set_missing;

double hills(std::int32_t x, std::int32_t y) {
  return std::round(800 * std::sin(0.17 * x) * std::cos(0.13 * y) + 30 * std::sin(1.3 * x + y));
}

TerrainSurface extract(const HeightGrid& grid, const TerrainOptions& options) {
  Progress progress;
  auto made = extract_terrain(grid, options, progress);
  if (!made) ADD_FAILURE() << made.error().message;
  return made ? std::move(made).value() : TerrainSurface{};
}

VerifyReport verify(const HeightGrid& grid, const Surface& surface, double max_error,
                    int n_threads = 2) {
  Progress progress;
  const auto report =
      verify_terrain(grid, surface, {.max_error = max_error, .threads = {n_threads}}, progress);
  EXPECT_TRUE(report);
  return report ? *report : VerifyReport{};
}

/// The first check that fails, or "".
std::string failed(const VerifyReport& report) {
  for (const VerifyReport::Check& check : report.checks)
    if (!check.passed) return check.name;
  return "";
}
std::string detail_of_failed(const VerifyReport& report) {
  for (const VerifyReport::Check& check : report.checks)
    if (!check.passed) return check.detail;
  return "";
}

/// A grid with its rows from north to south, as rasters are, or from south to north.
HeightGrid hilly_grid(bool is_mirrored) {
  HeightGrid grid = make_grid<std::int16_t>(50, 40, hills);
  grid.to_world = {500000.25, 30, 0, 4000000.5, 0, is_mirrored ? -30.0 : 30.0};
  return grid;
}

/// Whether a triangle has a part in a box: by cutting it along the box's sides.
bool has_part_in(std::vector<Vec<double, 2>> part, const PlaceBox& box) {
  for (const std::size_t axis : {0U, 1U})
    for (const double sign : {1.0, -1.0}) {
      const double limit = sign > 0 ? box.lower[axis] : box.upper[axis];
      const auto depth = [&](const Vec<double, 2>& p) { return sign * (p[axis] - limit); };
      std::vector<Vec<double, 2>> left;
      for (std::size_t i = 0; i < part.size(); ++i) {
        const Vec<double, 2>& a = part[i];
        const Vec<double, 2>& b = part[(i + 1) % part.size()];
        if (depth(a) >= 0) left.push_back(a);
        if ((depth(a) < 0) != (depth(b) < 0))
          left.push_back(a + (b - a) * (depth(a) / (depth(a) - depth(b))));
      }
      part = std::move(left);
    }
  return !part.empty();
}

TEST(terrain, knows_what_of_a_box_is_outside) {
  HeightGrid turned = hilly_grid(true);
  turned.to_world = {500000.25, 20, 11, 4000000.5, 9, -30};
  for (const HeightGrid& grid : {hilly_grid(false), hilly_grid(true)}) {
    const auto box = [&](double x0, double y0, double x1, double y1) {
      PlaceBox made{grid.world(x0, y0), grid.world(x1, y1)};
      for (const std::size_t i : {0U, 1U})
        if (made.lower[i] > made.upper[i]) std::swap(made.lower[i], made.upper[i]);
      return made;
    };
    // 50 x 40 samples: pixels from -0.5 to 49.5 and to 39.5.
    EXPECT_NEAR(share_outside(box(-0.5, -0.5, 49.5, 39.5), grid), 0, 1e-9);
    EXPECT_NEAR(share_outside(box(-10.5, 0, 9.5, 20), grid), 0.5, 1e-6);
    EXPECT_NEAR(share_outside(box(39.5, 29.5, 59.5, 49.5), grid), 0.75, 1e-6);
    EXPECT_NEAR(share_outside(box(-10.5, 5, 9.5, 5), grid), 0.5, 1e-5) << "a line";
    EXPECT_NEAR(share_outside(box(3, 3, 3, 3), grid), 0, 1e-6) << "a point";
    EXPECT_EQ(share_outside(box(60, 3, 70, 5), grid), 1);
  }
  // Half of it is beyond the first row, as rows and columns are oblique.
  const Vec<double, 2> middle = turned.world(20, 20);
  EXPECT_NEAR(share_outside({middle, middle + Vec<double, 2>{{100, 100}}}, turned), 0, 1e-9);
  const Vec<double, 2> corner = turned.world(-0.5, -0.5);
  const Vec<double, 2> reach{{30, 30}};
  const double share = share_outside({corner - reach, corner + reach}, turned);
  EXPECT_GT(share, 0.6);
  EXPECT_LT(share, 0.9);
}

TEST(terrain, keeps_the_triangles_that_meet_a_box_as_they_are) {
  HeightGrid turned = hilly_grid(true);
  turned.to_world = {500000.25, 20, 11, 4000000.5, 9, -30};
  for (const HeightGrid& grid : {hilly_grid(false), hilly_grid(true), turned}) {
    const TerrainSurface whole = extract(grid, {.max_error = 60});
    const auto corners = [](const Surface& surface, std::size_t t) {
      std::vector<Vec<double, 2>> places;
      for (const std::uint32_t v : surface.triangles[t])
        places.push_back({{surface.origin[0] + surface.positions[v][0],
                           surface.origin[1] + surface.positions[v][1]}});
      return places;
    };
    for (const double size : {1.0, 40.0, 400.0}) {
      const Vec<double, 2> middle = grid.world(21.3, 17.7);
      const PlaceBox box{middle, {{middle[0] + size, middle[1] + size / 2}}};
      Progress progress;
      const auto part = extract_terrain(grid, {.max_error = 60}, progress, box);
      ASSERT_TRUE(part) << part.error().message;
      std::vector<std::vector<Vec<double, 2>>> expected;
      for (std::size_t t = 0; t < whole.surface.triangles.size(); ++t)
        if (has_part_in(corners(whole.surface, t), box))
          expected.push_back(corners(whole.surface, t));
      ASSERT_EQ(part->surface.triangles.size(), expected.size());
      EXPECT_EQ(part->clip->n_kept, expected.size());
      EXPECT_EQ(part->clip->n_triangles, whole.surface.triangles.size());
      for (std::size_t t = 0; t < expected.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i)
          for (std::size_t axis = 0; axis < 2; ++axis)
            EXPECT_NEAR(corners(part->surface, t)[i][axis], expected[t][i][axis], 0.1);
      std::vector<bool> is_used(part->surface.positions.size(), false);
      for (const auto& triangle : part->surface.triangles)
        for (const std::uint32_t v : triangle) is_used[v] = true;
      EXPECT_EQ(std::ranges::count(is_used, false), 0);
      EXPECT_EQ(part->report.vertices, is_used.size());
    }
    Progress progress;
    const PlaceBox beside{{{0, 0}}, {{1, 1}}};
    const auto none = extract_terrain(grid, {.max_error = 60}, progress, beside);
    ASSERT_FALSE(none);
    EXPECT_NE(none.error().message.find("meets none of"), std::string::npos);
  }
}

/// What rounding errors are beside heights so small that products of them are none.
TEST(terrain, ends_at_heights_that_floats_hardly_hold) {
  const auto rough = [](std::int32_t x, std::int32_t y) { return (x * 7919 + y * 104729) % 1000; };
  for (const double unit : {1e-36, 1e-40, 1e-42, 1.5e-45}) {
    const auto tiny = [&](std::int32_t x, std::int32_t y) { return unit * rough(x, y); };
    for (const HeightGrid& grid :
         {make_grid<float>(41, 37, tiny), make_grid<double>(41, 37, [&](auto x, auto y) {
            return 1e-275 * tiny(x, y);  // Below what doubles hold in full.
          })})
      for (const InsertionOrder order :
           {InsertionOrder::levels, InsertionOrder::strict, InsertionOrder::tiles})
        for (const double share : {0.0, 1e-3, 0.1}) {
          const HeightRange range = height_range(grid);
          const double max_error = share * (range.upper - range.lower);
          const TerrainSurface made = extract(grid, {.max_error = max_error, .order = order});
          EXPECT_LE(made.report.achieved_error, max_error);
          EXPECT_LE(made.report.triangles, 2880U);
        }
  }
}

TEST(terrain, claims_no_error_that_rounding_may_have_made) {
  const HeightGrid plane =
      make_grid<double>(50, 40, [](std::int32_t x, std::int32_t y) { return 0.1 * x + 0.3 * y; });
  const HeightGrid tenths =
      make_grid<double>(50, 40, [](std::int32_t x, std::int32_t y) { return hills(x, y) / 10.0; });
  for (const HeightGrid& grid : {plane, tenths})
    for (const double max_error : {0.0, 1e-16, 1e-15, 1e-12}) {
      const TerrainSurface made = extract(grid, {.max_error = max_error});
      EXPECT_LE(made.report.achieved_error, max_error);
      const VerifyReport report = verify(grid, made.surface, max_error);
      for (const VerifyReport::Check& check : report.checks)
        if (check.name == "samples are within the error") EXPECT_TRUE(check.passed) << max_error;
    }
}

TEST(terrain, verification_finds_heights_moved_beside_a_large_one) {
  const HeightGrid grid = make_grid<double>(
      30, 20, [](std::int32_t x, std::int32_t y) { return 1e9 + hills(x, y) / 400; });
  TerrainSurface made = extract(grid, {.max_error = 0.1});
  EXPECT_EQ(failed(verify(grid, made.surface, 0.1)), "");
  made.surface.positions[7][2] += 0.5F;
  EXPECT_EQ(failed(verify(grid, made.surface, 0.1)), "vertices are samples");
}

TEST(terrain, faces_up_and_lies_at_the_samples_whichever_way_rows_run) {
  for (const bool is_mirrored : {false, true}) {
    const HeightGrid grid = hilly_grid(is_mirrored);
    const TerrainSurface made = extract(grid, {.max_error = 40});
    EXPECT_EQ(made.report.vertices, made.surface.positions.size());
    EXPECT_EQ(made.report.triangles, made.surface.triangles.size());
    for (const auto& t : made.surface.triangles) {
      const Vec3d a = made.surface.world_position(t[0]);
      const Vec3d u = made.surface.world_position(t[1]) - a;
      const Vec3d v = made.surface.world_position(t[2]) - a;
      EXPECT_GT(cross(u, v)[2], 0);
    }
    for (std::uint32_t v = 0; v < made.surface.positions.size(); ++v) {
      const Vec3d at = made.surface.world_position(v);
      const Vec<double, 2> node = grid.lattice(at[0], at[1]);
      EXPECT_EQ(at[2], grid.height(static_cast<std::int32_t>(std::lround(node[0])),
                                   static_cast<std::int32_t>(std::lround(node[1]))));
      EXPECT_EQ(at[2], made.surface.values[v]);
    }
    EXPECT_EQ(failed(verify(grid, made.surface, 40)), "");
    EXPECT_EQ(made.report.height_slack, 0);
  }
}

TEST(terrain, states_how_far_coordinates_in_floats_are_off) {
  HeightGrid grid = make_grid<double>(
      30, 30, [](std::int32_t x, std::int32_t y) { return 1e9 + 0.01 * hills(x, y); });
  grid.to_world = {1.0 / 3, 1.0 / 1200, 0, 2.0 / 3, 0, -1.0 / 1200};
  const TerrainSurface made = extract(grid, {.max_error = 0.5});
  double height_offset = 0;
  double position_offset = 0;
  for (std::uint32_t v = 0; v < made.surface.positions.size(); ++v) {
    const Vec3d at = made.surface.world_position(v);
    const Vec<double, 2> node = grid.lattice(at[0], at[1]);
    const double x = std::round(node[0]);
    const double y = std::round(node[1]);
    height_offset = std::max(height_offset, std::abs(at[2] - made.surface.values[v]));
    position_offset = std::max({position_offset, std::abs(at[0] - grid.world(x, y)[0]),
                                std::abs(at[1] - grid.world(x, y)[1])});
  }
  EXPECT_EQ(made.report.height_slack, height_offset);
  EXPECT_LT(height_offset, 1e-6) << "centimetres at 1e9 need an origin";
  EXPECT_EQ(made.report.position_slack, position_offset);
  EXPECT_LT(position_offset, 1e-8);
  EXPECT_EQ(failed(verify(grid, made.surface, 0.5)), "");
}

TEST(terrain, has_places_in_float64_where_heights_are_too_far_apart_for_floats) {
  // A tower of 1e9 on one side, centimetres on both.
  const HeightGrid grid = make_grid<double>(24, 17, [](std::int32_t x, std::int32_t y) {
    return (x > 14 ? 1e9 : 0.0) + 0.01 * std::round(hills(x, y));
  });
  const TerrainSurface made = extract(grid, {.max_error = 0.02});
  EXPECT_GT(made.report.height_slack, 0.5);
  ASSERT_EQ(made.places.size(), made.surface.positions.size());
  const auto verified = [&](std::span<const Vec3d> places) {
    Progress progress;
    return failed(
        verify_terrain(grid, made.surface, {.max_error = 0.02, .places = places}, progress)
            .value());
  };
  EXPECT_NE(verified({}), "") << "floats have other heights";
  EXPECT_EQ(verified(made.places), "");
  // A centimetre off is seen.
  std::vector<Vec3d> moved = made.places;
  for (Vec3d& place : moved)
    if (place[2] > 1e8) place[2] += 0.03;
  EXPECT_NE(verified(moved), "");
  // Floats that have all heights have no places.
  EXPECT_TRUE(extract(hilly_grid(true), {.max_error = 40}).places.empty());
}

TEST(terrain, keeps_max_cells_and_says_what_error_that_leaves) {
  const HeightGrid grid = hilly_grid(true);
  double last = 1e9;
  for (const std::uint64_t n : {2U, 3U, 10U, 57U, 400U}) {
    const TerrainSurface made = extract(grid, {.max_cells = n});
    EXPECT_LE(made.report.triangles, n);
    EXPECT_GE(made.report.triangles + 1, n);
    EXPECT_TRUE(made.report.budget_met);
    EXPECT_FALSE(made.report.is_within_error);
    EXPECT_LT(made.report.achieved_error, last * 1.5);
    last = made.report.achieved_error;
    EXPECT_EQ(failed(verify(grid, made.surface, made.report.achieved_error)), "");
    EXPECT_EQ(failed(verify(grid, made.surface, made.report.achieved_error * 0.99)),
              "samples are within the error");
  }
  HeightGrid island = grid;
  set_missing(island, 20, 20);
  const TerrainSurface outline = extract(island, {.max_cells = 3});
  EXPECT_FALSE(outline.report.budget_met);
  EXPECT_GT(outline.report.triangles, 3U);
}

TEST(terrain, stops_at_the_tolerance_before_max_cells) {
  const HeightGrid grid = hilly_grid(true);
  const TerrainSurface strict = extract(grid, {.max_error = 60, .order = InsertionOrder::strict});
  const TerrainSurface both = extract(grid, {.max_error = 60, .max_cells = 100000});
  EXPECT_EQ(both.surface.triangles, strict.surface.triangles);
  EXPECT_TRUE(both.report.is_within_error);
}

TEST(terrain, has_a_default_tolerance) {
  const HeightGrid grid = hilly_grid(true);
  const HeightRange range = height_range(grid);
  const TerrainSurface made = extract(grid, {});
  EXPECT_DOUBLE_EQ(made.report.max_error, 0.005 * (range.upper - range.lower));
  EXPECT_LE(made.report.achieved_error, made.report.max_error);
}

TEST(terrain, covers_cells_with_four_heights_only_and_counts_the_rest) {
  HeightGrid grid = hilly_grid(true);
  for (std::int32_t y = 0; y < 40; ++y)
    for (std::int32_t x = 0; x < 50; ++x)
      if (x > y + 30 || (x * 31 + y * 17) % 43 == 0 ||
          (x - 15) * (x - 15) + (y - 20) * (y - 20) < 30)
        set_missing(grid, x, y);
  const TerrainSurface made = extract(grid, {.max_error = 25});
  EXPECT_EQ(failed(verify(grid, made.surface, 25)), "");
  EXPECT_EQ(made.report.n_missing, grid.n_missing());
  EXPECT_EQ(made.report.n_samples + made.report.n_missing + made.report.n_left_out, 2000U);
  const TerrainInfo info = describe_terrain(grid);
  EXPECT_EQ(info.n_missing, grid.n_missing());
  EXPECT_EQ(info.n_left_out, made.report.n_left_out);
}

/// Of several tiles, whose seams are columns 150 and row 100.
class tiled_terrain : public testing::Test {
 protected:
  tiled_terrain() : grid_(make_grid<std::int16_t>(301, 201, hills)) {
    for (std::int32_t i = 0; i < 40; ++i) set_missing(grid_, 130 + i, 90 + i / 2);
    made_ = extract(grid_, {.max_error = 40, .order = InsertionOrder::tiles});
  }
  [[nodiscard]] VerifyReport verify_as(TinShape shape, const Surface& surface) const {
    Progress progress;
    const auto report =
        verify_terrain(grid_, surface, {.max_error = 40, .shape = shape, .threads = {2}}, progress);
    EXPECT_TRUE(report);
    return report ? *report : VerifyReport{};
  }

  HeightGrid grid_;
  TerrainSurface made_;
};

TEST_F(tiled_terrain, is_right_but_for_edges_on_seams) {
  EXPECT_EQ(failed(verify_as(TinShape::tiles, made_.surface)), "");
  const VerifyReport as_delaunay = verify_as(TinShape::delaunay, made_.surface);
  EXPECT_EQ(failed(as_delaunay), "inner edges are Delaunay");
  EXPECT_NE(detail_of_failed(as_delaunay).find("\"tiles\""), std::string::npos);
  EXPECT_LE(made_.report.achieved_error, 40);
  const TerrainSurface whole = extract(grid_, {.max_error = 40});
  EXPECT_EQ(failed(verify_as(TinShape::tiles, whole.surface)), "");
  EXPECT_EQ(made_.report.n_samples, whole.report.n_samples);
  EXPECT_EQ(made_.report.n_left_out, whole.report.n_left_out);
}

/// A surface in which nothing is on a line that no triangle crosses is held against all of
/// Delaunay.
TEST_F(tiled_terrain, must_be_delaunay_where_triangles_cross_the_seam) {
  Surface& surface = made_.surface;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> sides;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e)
      sides[{surface.triangles[t][e], surface.triangles[t][(e + 1) % 3]}] = 3 * t + e;
  const auto x_of = [&](std::uint32_t v) {
    const Vec3d at = surface.world_position(v);
    return std::lround(grid_.lattice(at[0], at[1])[0]);
  };
  for (const auto& [ends, side] : sides) {
    if (x_of(ends.first) != 150 || x_of(ends.second) != 150) continue;
    const auto other = sides.find({ends.second, ends.first});
    if (other == sides.end()) continue;
    // Turned, the edge crosses column 150, which is no seam any more.
    Surface turned = surface;
    const std::uint32_t c = surface.triangles[side / 3][(side % 3 + 2) % 3];
    const std::uint32_t d = surface.triangles[other->second / 3][(other->second % 3 + 2) % 3];
    turned.triangles[side / 3] = {c, ends.first, d};
    turned.triangles[other->second / 3] = {d, ends.second, c};
    const std::string what = failed(verify_as(TinShape::tiles, turned));
    if (what == "triangles face up") continue;
    EXPECT_EQ(what, "inner edges are Delaunay or on seams");
    EXPECT_EQ(detail_of_failed(verify_as(TinShape::delaunay, turned)).find("tiles"),
              std::string::npos);
    return;
  }
  FAIL() << "no edge of the seam could be turned";
}

TEST(terrain, of_points_is_refused_in_tiles) {
  PointTerrain terrain;
  terrain.points.nodes = {{0, 0}, {9, 0}, {0, 9}};
  terrain.points.heights = {1, 2, 3};
  Progress progress;
  const auto made = extract_terrain(to_terrain(std::make_shared<const PointTerrain>(terrain)),
                                    {.max_error = 1, .order = InsertionOrder::tiles}, progress);
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("tiles"), std::string::npos) << made.error().message;
}

class broken_terrain : public testing::Test {
 protected:
  broken_terrain() : grid_(hilly_grid(true)), surface_(extract(grid_, {.max_error = 40}).surface) {}

  HeightGrid grid_;
  Surface surface_;
};

TEST_F(broken_terrain, is_found_where_a_triangle_is_missing_or_doubled) {
  Surface lacking = surface_;
  lacking.triangles.pop_back();
  EXPECT_EQ(failed(verify(grid_, lacking, 40)), "the domain is covered once");
  Surface doubled = surface_;
  doubled.triangles.push_back(doubled.triangles.back());
  EXPECT_EQ(failed(verify(grid_, doubled, 40)), "edges have two sides");
}

TEST_F(broken_terrain, is_found_where_a_triangle_is_turned) {
  std::swap(surface_.triangles[7][0], surface_.triangles[7][1]);
  EXPECT_EQ(failed(verify(grid_, surface_, 40)), "triangles face up");
}

TEST_F(broken_terrain, is_found_where_a_vertex_is_moved) {
  Surface up = surface_;
  up.positions[11][2] += 1;
  EXPECT_EQ(failed(verify(grid_, up, 1e6)), "vertices are samples");
  Surface aside = surface_;
  aside.positions[11][0] += 10;
  EXPECT_EQ(failed(verify(grid_, aside, 1e6)), "vertices are samples");
}

TEST_F(broken_terrain, is_found_where_an_edge_is_flipped) {
  // The first inner edge whose two triangles are strictly convex together.
  auto& triangles = surface_.triangles;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t j = i + 1; j < triangles.size(); ++j)
      for (std::size_t e = 0; e < 3; ++e) {
        const auto a = triangles[i][e];
        const auto b = triangles[i][(e + 1) % 3];
        const auto c = triangles[i][(e + 2) % 3];
        for (std::size_t f = 0; f < 3; ++f) {
          if (triangles[j][f] != b || triangles[j][(f + 1) % 3] != a) continue;
          const auto d = triangles[j][(f + 2) % 3];
          Surface flipped = surface_;
          flipped.triangles[i] = {c, a, d};
          flipped.triangles[j] = {d, b, c};
          const std::string what = failed(verify(grid_, flipped, 1e6));
          if (what == "triangles face up") continue;
          // Of four cocircular corners either edge is Delaunay.
          if (what.empty()) continue;
          EXPECT_EQ(what, "inner edges are Delaunay");
          return;
        }
      }
  FAIL() << "no edge could be flipped";
}

TEST_F(broken_terrain, is_judged_the_same_by_any_number_of_threads) {
  const VerifyReport one = verify(grid_, surface_, 10, 1);
  const VerifyReport four = verify(grid_, surface_, 10, 4);
  ASSERT_EQ(one.checks.size(), four.checks.size());
  for (std::size_t i = 0; i < one.checks.size(); ++i) {
    EXPECT_EQ(one.checks[i].detail, four.checks[i].detail);
    EXPECT_EQ(one.checks[i].count, four.checks[i].count);
  }
  EXPECT_EQ(failed(one), "samples are within the error");
}

TEST(terrain, refuses_grids_without_area_and_stops_when_cancelled) {
  Progress progress;
  const HeightGrid row = make_grid<float>(9, 1, hills);
  EXPECT_FALSE(extract_terrain(row, {}, progress));
  const HeightGrid huge = make_grid<double>(
      5, 5, [](std::int32_t x, std::int32_t) { return x == 2 ? -1.7e308 : 1.7e308; });
  EXPECT_FALSE(extract_terrain(huge, {}, progress));
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(extract_terrain(hilly_grid(true), {.max_error = 1}, cancelled));
}

}  // namespace
}  // namespace lode
