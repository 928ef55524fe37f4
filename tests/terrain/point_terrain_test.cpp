#include "lode/api/point_terrain.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "lode/api/terrain_selection.h"
#include "lode/api/terrain_tin.h"
#include "tests/delaunay/point_fixtures.h"

namespace lode {
namespace {

using delaunay::test::circle_sign;
using delaunay::test::Int128;

double hills(double x, double y) { return 40 * std::sin(x / 90) * std::cos(y / 70) + x / 50; }

/// At whole centimetres far from the origin, as surveys are.
std::vector<Vec3d> survey(int n, std::uint64_t seed = 1) {
  std::vector<Vec3d> points;
  for (const LatticePoint& p : delaunay::test::random_nodes(n, 60000, seed))
    points.push_back({{500000 + p.x * 0.01, 4000000 + p.y * 0.01, hills(p.x * 0.01, p.y * 0.01)}});
  return points;
}

constexpr PointLattice kCentimetres{{0, 0}, 0.01};

Result<PointTerrain> try_make(const std::vector<Vec3d>& points,
                              const PointTerrainOptions& options = {},
                              const PointLattice& lattice = kCentimetres) {
  Progress progress;
  return make_point_terrain(points, lattice, {}, options, progress);
}

PointTerrain make(const std::vector<Vec3d>& points, const PointTerrainOptions& options = {},
                  const PointLattice& lattice = kCentimetres) {
  auto made = try_make(points, options, lattice);
  if (!made) ADD_FAILURE() << made.error().message;
  return made ? std::move(made).value() : PointTerrain{};
}

delaunay::Tin select(const PointTerrain& terrain, const TerrainOptions& options) {
  Progress progress;
  auto made = select_terrain(terrain, options, delaunay::TinLinks::kept, progress);
  EXPECT_TRUE(made);
  return made ? std::move(made->tin) : delaunay::Tin{};
}

TerrainSurface extract(const PointTerrain& terrain, const TerrainOptions& options) {
  Progress progress;
  auto made =
      extract_terrain(to_terrain(std::make_shared<const PointTerrain>(terrain)), options, progress);
  EXPECT_TRUE(made);
  return made ? std::move(made).value() : TerrainSurface{};
}

/// The first check that fails, or "".
std::string failed(const PointTerrain& terrain, const Surface& surface, double max_error) {
  Progress progress;
  const auto report =
      verify_terrain(terrain, surface, {.max_error = max_error, .threads = {2}}, progress);
  EXPECT_TRUE(report);
  for (const VerifyReport::Check& check : report->checks)
    if (!check.passed) return check.name;
  return "";
}

std::int64_t doubled_area(const delaunay::Tin& tin) {
  std::int64_t area = 0;
  for (const auto& t : tin.triangles)
    area += delaunay::doubled_area(tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]]);
  return area;
}

/// All triples of points whose circle holds no other: Delaunay by definition, where no four are on
/// one circle.
std::vector<std::array<std::uint32_t, 3>> all_delaunay(const std::vector<LatticePoint>& nodes) {
  std::vector<std::array<std::uint32_t, 3>> made;
  const auto n = static_cast<std::uint32_t>(nodes.size());
  for (std::uint32_t a = 0; a < n; ++a)
    for (std::uint32_t b = a + 1; b < n; ++b)
      for (std::uint32_t c = a + 1; c < n; ++c) {
        if (delaunay::doubled_area(nodes[a], nodes[b], nodes[c]) <= 0) continue;
        bool is_empty = true;
        for (std::uint32_t d = 0; d < n && is_empty; ++d)
          is_empty = circle_sign(nodes[a], nodes[b], nodes[c], nodes[d]) <= 0;
        if (is_empty) made.push_back({a, b, c});
      }
  return made;
}

/// Held against the definition: the area of what is kept, and the points that are its corners.
void expect_domain(const PointTerrain& terrain,
                   const std::function<bool(const std::array<Vec<double, 2>, 3>&)>& is_kept) {
  const auto& nodes = terrain.points.nodes;
  std::int64_t area = 0;
  std::set<std::uint32_t> corners;
  for (const auto& t : all_delaunay(nodes)) {
    std::array<Vec<double, 2>, 3> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = terrain.points.world(nodes[t[i]].x, nodes[t[i]].y);
    if (!is_kept(at)) continue;
    area += delaunay::doubled_area(nodes[t[0]], nodes[t[1]], nodes[t[2]]);
    corners.insert(t.begin(), t.end());
  }
  EXPECT_EQ(terrain.domain.n_left_out, nodes.size() - corners.size());
  for (const double max_error : {0.0, 5.0, 1e9}) {
    const delaunay::Tin tin = select(terrain, {.max_error = max_error});
    EXPECT_EQ(doubled_area(tin), area) << max_error;
    delaunay::test::expect_locally_delaunay(tin);
    for (const auto& edge : terrain.domain.outline)
      for (const std::uint32_t end : edge)
        EXPECT_EQ(std::ranges::count(tin.vertices, nodes[end]), 1) << "a corner is lost";
  }
}

TEST(point_terrain, is_within_the_error_at_every_point_and_passes_other_checks) {
  const PointTerrain terrain = make(survey(3000));
  EXPECT_LE(terrain.points.largest_move, 2e-9);
  for (const InsertionOrder order : {InsertionOrder::levels, InsertionOrder::strict})
    for (const double max_error : {0.0, 0.05, 2.0, 1000.0}) {
      const TerrainSurface made = extract(terrain, {.max_error = max_error, .order = order});
      EXPECT_LE(made.report.achieved_error, max_error);
      EXPECT_EQ(made.report.n_samples, terrain.points.nodes.size());
      EXPECT_EQ(failed(terrain, made.surface, max_error), "");
      const double less = 0.9 * made.report.achieved_error;
      if (max_error == 2)
        EXPECT_EQ(failed(terrain, made.surface, less), "samples are within the error");
    }
}

TEST(point_terrain, checks_find_what_is_wrong_with_a_surface) {
  const PointTerrain terrain = make(survey(500));
  const Surface good = extract(terrain, {.max_error = 1}).surface;
  ASSERT_EQ(failed(terrain, good, 1), "");
  Surface bad = good;
  bad.positions[7][2] += 0.5F;
  EXPECT_EQ(failed(terrain, bad, 1), "vertices are samples");
  bad = good;
  bad.positions[7][0] += 0.5F;
  EXPECT_EQ(failed(terrain, bad, 1), "vertices are samples");
  bad = good;
  bad.triangles.pop_back();
  EXPECT_EQ(failed(terrain, bad, 1), "the domain is covered once");
  bad = good;
  bad.triangles.push_back(good.triangles[0]);
  EXPECT_EQ(failed(terrain, bad, 1), "edges have two sides");
  bad = good;
  std::swap(bad.triangles[3][0], bad.triangles[3][1]);
  EXPECT_EQ(failed(terrain, bad, 1), "triangles face up");
}

/// At tolerance 0 each point is found, on the hull as well, and has its own height.
TEST(point_terrain, has_the_height_of_every_point_at_its_place) {
  std::vector<Vec3d> points = survey(2000, 3);
  for (int i = 0; i <= 40; ++i)  // On edges of the hull that are oblique.
    points.push_back({{499000 + 10.01 * i, 3999000 + 20.02 * i, 1.0 * i}});
  const auto terrain = std::make_shared<const PointTerrain>(make(points));
  Progress progress;
  const auto tin = TerrainTin::select(to_terrain(terrain), {.max_error = 0}, {}, progress);
  ASSERT_TRUE(tin);
  std::vector<Place> places;
  for (const Vec3d& p : points) places.push_back({{p[0], p[1]}});
  std::vector<TerrainHeight> heights;
  const auto report = tin->heights(places, heights, {1}, progress);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->n_outside + report->n_in_gaps, 0U);
  ASSERT_EQ(terrain->points.n_repeated, 0U);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LE(std::abs(heights[i].height - points[i][2]), heights[i].bound) << i;
}

TEST(point_terrain, of_a_regular_grid_has_all_its_cells) {
  std::vector<Vec3d> points;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      points.push_back({{x * 10.0, y * 10.0, std::round(hills(x * 10, y * 10))}});
  const PointTerrain terrain = make(points, {}, {{0, 0}, 10});
  EXPECT_EQ(terrain.domain.outline.size(), 4U);
  EXPECT_EQ(terrain.domain.triangles.size(), 2U);
  const delaunay::Tin all = select(terrain, {.max_error = 0});
  EXPECT_EQ(all.triangles.size(), 2U * 29 * 39);
  EXPECT_EQ(failed(terrain, extract(terrain, {.max_error = 3}).surface, 3), "");
}

TEST(point_terrain, leaves_out_triangles_with_longer_edges_wherever_they_are) {
  for (const double longest : {40.0, 90.0, 150.0}) {
    const PointTerrain terrain = make(survey(60, 5), {.max_edge = longest});
    expect_domain(terrain, [&](const auto& at) {
      return length(at[1] - at[0]) <= longest && length(at[2] - at[1]) <= longest &&
             length(at[0] - at[2]) <= longest;
    });
    EXPECT_EQ(failed(terrain, extract(terrain, {.max_error = 1}).surface, 1), "");
  }
  const auto none = try_make(survey(60, 5), {.max_edge = 1e-3});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("got none of"), std::string::npos);
}

TEST(point_terrain, ends_at_an_outline_that_is_given) {
  const std::vector<Place> square{
      {{500100, 4000100}}, {{500500, 4000100}}, {{500500, 4000500}}, {{500100, 4000500}}};
  const std::vector<Vec3d> points = survey(90, 6);
  const PointTerrain terrain = make(points, {.outline = {{square}}});
  const auto is_in = [](double x, double y) {
    return x >= 500100 && x <= 500500 && y >= 4000100 && y <= 4000500;
  };
  const auto n_in = static_cast<std::uint64_t>(
      std::ranges::count_if(points, [&](const Vec3d& p) { return is_in(p[0], p[1]); }));
  EXPECT_EQ(terrain.points.nodes.size(), n_in);
  EXPECT_EQ(terrain.n_outside, points.size() - n_in);
  // A notch: what lies between its sides is left out, though its corners are inside.
  std::vector<Place> notched = square;
  notched.insert(notched.begin() + 1, {{500300, 4000450}});
  const PointTerrain part = make(points, {.outline = {{notched}}});
  expect_domain(part, [&](const auto& at) {
    const Place middle = (at[0] + at[1] + at[2]) * (1.0 / 3);
    const double from_middle = std::abs(middle[0] - 500300);
    return is_in(middle[0], middle[1]) && middle[1] - 4000100 >= 350 * (1 - from_middle / 200);
  });
  const std::vector<Place> elsewhere{{{0, 0}}, {{1, 0}}, {{0, 1}}};
  EXPECT_FALSE(try_make(points, {.outline = {{elsewhere}}}));
  EXPECT_FALSE(try_make(points, {.outline = {{{square[0], square[1]}}}}));
}

TEST(point_terrain, keeps_holes_and_all_polygons_of_an_outline) {
  const auto box = [](double x0, double x1, double y0, double y1) {
    return std::vector<Place>{{{x0, y0}}, {{x1, y0}}, {{x1, y1}}, {{x0, y1}}};
  };
  const PlacePolygon holed{box(500050, 500350, 4000050, 4000550),
                           box(500150, 500250, 4000200, 4000400)};
  // What is in two polygons is in, though it is in an even number.
  const PlacePolygon other{box(500300, 500550, 4000300, 4000500)};
  const PointTerrain terrain = make(survey(110, 7), {.outline = {holed, other}});
  const auto is_in = [](const Place& p) {
    const auto within = [&](double x0, double x1, double y0, double y1) {
      return p[0] > x0 && p[0] < x1 && p[1] > y0 && p[1] < y1;
    };
    return (within(500050, 500350, 4000050, 4000550) &&
            !within(500150, 500250, 4000200, 4000400)) ||
           within(500300, 500550, 4000300, 4000500);
  };
  expect_domain(terrain,
                [&](const auto& at) { return is_in((at[0] + at[1] + at[2]) * (1.0 / 3)); });
  EXPECT_GT(terrain.n_outside, 20U);
  EXPECT_EQ(failed(terrain, extract(terrain, {.max_error = 1}).surface, 1), "");
}

TEST(point_terrain, has_one_height_where_points_are_repeated) {
  std::vector<Vec3d> points{{{0, 0, 0}}, {{10, 0, 0}}, {{0, 10, 0}}, {{0, 10, 3}}, {{2, 2, 1}}};
  for (const auto& [repeated, height] : {std::pair{RepeatedHeights::mean, 1.5},
                                         {RepeatedHeights::lowest, 0.0},
                                         {RepeatedHeights::highest, 3.0}}) {
    const PointTerrain terrain = make(points, {.repeated = repeated});
    EXPECT_EQ(select(terrain, {.max_error = 0}).heights, (std::vector<double>{0, 0, 1, height}));
  }
  EXPECT_FALSE(try_make(points, {.repeated = RepeatedHeights::refused}));
}

TEST(point_terrain, refuses_points_that_span_no_area) {
  const auto refusal = [](const std::vector<Vec3d>& points) {
    const auto made = try_make(points);
    EXPECT_FALSE(made);
    return made ? std::string() : made.error().message;
  };
  const std::string reason = "at least three points that are not on one line";
  EXPECT_NE(refusal({{{1, 1, 1}}}).find(reason), std::string::npos);
  EXPECT_NE(refusal({{{1, 1, 1}}, {{2, 2, 1}}}).find(reason), std::string::npos);
  EXPECT_NE(refusal({{{1, 1, 1}}, {{1, 1, 2}}, {{1, 1, 5}}}).find(reason), std::string::npos);
  EXPECT_NE(refusal({{{0, 0, 1}}, {{1, 2, 2}}, {{2, 4, 5}}, {{7, 14, 9}}}).find(reason),
            std::string::npos);
  EXPECT_NE(refusal({}).find("expected points, got none"), std::string::npos);
}

TEST(point_terrain, keeps_the_outline_with_few_triangles_and_can_be_cancelled) {
  const PointTerrain terrain = make(survey(400, 9), {.max_edge = 60});
  const TerrainSurface few = extract(terrain, {.max_cells = 10});
  EXPECT_FALSE(few.report.budget_met);
  EXPECT_EQ(few.report.triangles, terrain.domain.triangles.size());
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(make_point_terrain(survey(400, 9), kCentimetres, {}, {.max_edge = 60}, progress));
}

}  // namespace
}  // namespace lode
