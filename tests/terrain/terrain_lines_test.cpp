#include "lode/api/terrain_lines.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include "lode/api/terrain_tin.h"
#include "tests/delaunay/point_fixtures.h"
#include "tests/oracles/random.h"
#include "tests/terrain/height_grids.h"

namespace lode {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double ridges(double x, double y) {
  return 60 * std::sin(x / 5) * std::cos(y / 7) + 20 * std::sin(x * y / 90) + x / 3;
}

/// Rows from north to south, of 30 by 20 metres.
HeightGrid raster(int n_columns = 48, int n_rows = 39) {
  HeightGrid grid = test::float_grid(n_columns, n_rows, [](int x, int y) { return ridges(x, y); });
  grid.to_world = {500000, 30, 0, 4000000, 0, -20};
  return grid;
}
/// World x, y of columns and rows of it, with a height.
Vec3d at(double x, double y, double z = kNaN) { return {{500000 + 30 * x, 4000000 - 20 * y, z}}; }

template <typename Source>
LinedTerrain add(const Source& source, const TerrainLineOptions& options) {
  Progress progress;
  auto made = add_lines(source, options, progress);
  if (!made) ADD_FAILURE() << made.error().message;
  return made ? std::move(made).value() : LinedTerrain{};
}

std::shared_ptr<const PointTerrain> shared(const LinedTerrain& made) {
  return std::make_shared<const PointTerrain>(made.terrain);
}

TerrainTin select_tin(const LinedTerrain& made, double max_error) {
  Progress progress;
  auto tin = TerrainTin::select(to_terrain(shared(made)), {.max_error = max_error}, {}, progress);
  EXPECT_TRUE(tin) << tin.error().message;
  return std::move(tin).value();
}

/// That verify has nothing to say.
void expect_passes(const LinedTerrain& made, double max_error) {
  Progress progress;
  const auto surface =
      extract_terrain(to_terrain(shared(made)), {.max_error = max_error}, progress);
  ASSERT_TRUE(surface) << surface.error().message;
  const auto report =
      verify_terrain(made.terrain, surface->surface, {.max_error = max_error}, progress);
  ASSERT_TRUE(report) << report.error().message;
  for (const auto& check : report->checks) EXPECT_TRUE(check.passed) << check.name;
}

/// The largest distance of a TIN's profile from a rule for heights, by where on the way from a to
/// b.
template <typename Rule>
double largest_gap(const TerrainTin& tin, const Vec3d& a, const Vec3d& b, const Rule& rule) {
  Progress progress;
  std::vector<Place> places;
  constexpr int kSteps = 997;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    const Vec3d p = a * (1 - t) + b * t;
    places.push_back({{p[0], p[1]}});
  }
  std::vector<TerrainHeight> heights(places.size());
  EXPECT_TRUE(tin.heights(places, heights, {}, progress));
  double gap = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_EQ(heights[i].where, TerrainHeight::Where::inside);
    gap = std::max(gap,
                   std::abs(heights[i].height - rule(static_cast<double>(i) / kSteps, places[i])));
  }
  return gap;
}

TEST(terrain_lines, of_features_are_edges_at_every_tolerance) {
  const HeightGrid grid = raster();
  for (const double relief : {0.0, 15.0, 1000.0}) {
    const LinedTerrain made = add(grid, {.least_relief = relief});
    ASSERT_TRUE(made.report.kept_features);
    const auto& kept = *made.report.kept_features;
    EXPECT_EQ(
        static_cast<std::int64_t>(kept.peaks + kept.pits) - static_cast<std::int64_t>(kept.passes),
        1);
    for (const double max_error : {0.0, 3.0, 1e6}) {
      SCOPED_TRACE(testing::Message() << relief << ", " << max_error);
      expect_passes(made, max_error);
    }
  }
}

/// Peaks and pits by their neighbours, as no pass is needed to find them.
TEST(terrain_lines, of_features_keep_peaks_that_a_tolerance_would_lose) {
  const HeightGrid grid = test::float_grid(30, 30, [](int x, int y) {
    return x == 7 && y == 11 ? 9.0 : x == 20 && y == 19 ? -9.0 : x * 0.25;
  });
  const auto has_vertex = [](const TerrainSurface& made, double x, double y) {
    for (std::uint32_t v = 0; v < made.surface.positions.size(); ++v) {
      const Vec3d p = made.surface.world_position(v);
      if (p[0] == x && p[1] == y) return true;
    }
    return false;
  };
  Progress progress;
  const LinedTerrain made = add(grid, {.least_relief = 5});
  const auto with = extract_terrain(to_terrain(shared(made)), {.max_error = 50}, progress);
  const auto without = extract_terrain(Terrain(grid), {.max_error = 50}, progress);
  ASSERT_TRUE(with && without);
  EXPECT_TRUE(has_vertex(*with, 7, 11));
  EXPECT_TRUE(has_vertex(*with, 20, 19));
  EXPECT_FALSE(has_vertex(*without, 7, 11));
}

TEST(terrain_lines, of_breaklines_have_their_own_heights_all_along) {
  const HeightGrid grid = raster();
  const std::vector<PlaceLine> lines{
      {at(3.25, 4.75, 500), at(20.125, 30.25, 540), at(40.875, 31.5, 100)},
      {at(30, 5, -50), at(30, 20, -80)}};
  const LinedTerrain made = add(grid, {.breaklines = lines});
  EXPECT_EQ(made.report.n_own_heights, 2);
  EXPECT_EQ(made.report.n_outside + made.report.n_cut + made.report.n_crossing, 0);
  // On the lattice, which is 1024 times finer, so that all along is exactly that.
  EXPECT_LT(made.report.largest_move, 1e-9);
  EXPECT_EQ(made.report.n_replaced, 16) << "all of the second line";
  for (const double max_error : {0.0, 5.0, 1e6}) {
    SCOPED_TRACE(max_error);
    expect_passes(made, max_error);
    const TerrainTin tin = select_tin(made, max_error);
    for (const PlaceLine& line : lines)
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const double gap = largest_gap(tin, line[i], line[i + 1], [&](double t, const Place&) {
          return line[i][2] * (1 - t) + line[i + 1][2] * t;
        });
        EXPECT_LT(gap, 1e-2);
      }
  }
}

TEST(terrain_lines, that_meet_at_different_heights_are_counted) {
  const HeightGrid grid = raster();
  const auto report_of = [&](const std::vector<PlaceLine>& lines) {
    return add(grid, {.breaklines = lines}).report;
  };
  // Across each other in two places, 10 and 25 apart; ends that touch, one 2 above the other.
  const PlaceLine along{at(5, 10, 100), at(25, 10, 100)};
  const auto crossed = report_of({along,
                                  {at(10, 5, 110), at(10, 15, 110)},
                                  {at(20, 5, 75), at(20, 15, 75)},
                                  {at(25, 10, 102), at(30, 20, 0)}});
  EXPECT_EQ(crossed.n_unequal, 3);
  EXPECT_NEAR(crossed.largest_spread, 25, 1e-9);
  // At one height, over one another, at a corner of its own, and one beside another.
  const auto joined = report_of({along,
                                 {at(10, 5, 100), at(10, 15, 100)},
                                 {at(25, 10, 100), at(30, 20, 0), at(35, 20, 10)},
                                 {at(5, 10, 100), at(15, 10, 100)},
                                 {at(12, 12, 3), at(25, 12, 4)}});
  EXPECT_EQ(joined.n_unequal, 0);
  EXPECT_EQ(joined.largest_spread, 0);
  // With itself; and nearer vertices than nodes are no meeting.
  EXPECT_EQ(report_of({{at(5, 5, 0), at(20, 20, 30), at(20, 5, 30), at(5, 20, 60)}}).n_unequal, 1);
  PlaceLine dense;
  for (int i = 0; i <= 5000; ++i) dense.push_back(at(5 + i * 1e-4, 7, i));
  EXPECT_EQ(report_of({dense}).n_unequal, 0);
}

TEST(terrain_lines, that_are_draped_follow_the_surface) {
  const HeightGrid grid = raster();
  const Vec3d a = at(2.2, 3.1, 9999);
  const Vec3d b = at(44.6, 35.3, 9999);
  Progress progress;
  const auto full = TerrainTin::select(Terrain(grid), {.max_error = 0}, {}, progress);
  ASSERT_TRUE(full);
  for (const double drape_error : {0.0, 2.0, 30.0})
    for (const bool has_heights : {false, true}) {
      TerrainLineOptions options{.is_draped = has_heights, .drape_error = drape_error};
      options.breaklines = {{a, b}};
      for (Vec3d& p : options.breaklines[0]) p[2] = has_heights ? 9999 : kNaN;
      const LinedTerrain made = add(grid, options);
      EXPECT_EQ(made.report.n_own_heights, 0);
      EXPECT_EQ(made.report.n_replaced, 0);
      expect_passes(made, 4);
      const TerrainTin tin = select_tin(made, 1e6);
      const double gap = largest_gap(tin, a, b, [&](double, const Place& p) {
        std::vector<TerrainHeight> height(1);
        EXPECT_TRUE(full->heights(std::array{p}, height, {}, progress));
        return height[0].height;
      });
      // Between looks, half a cell apart, the surface may bend once more.
      EXPECT_LT(gap, drape_error + 4) << drape_error;
      if (drape_error == 30) EXPECT_LT(made.report.n_edges, 12);
    }
}

/// The largest distance of a TIN from heights at t = 0 and 1, linear between.
double gap_from(const TerrainTin& tin, const Vec3d& a, const Vec3d& b) {
  return largest_gap(tin, a, b, [&](double t, const Place&) { return a[2] * (1 - t) + b[2] * t; });
}

/// Corners of holes, single peaks and lines without heights lie on them.
TEST(terrain_lines, of_breaklines_keep_their_heights_whatever_they_meet) {
  HeightGrid grid = raster();
  grid.is_valid.assign(static_cast<std::size_t>(grid.n_samples()), 1);
  for (int y = 10; y < 20; ++y)
    for (int x = 10; x < 20; ++x)
      grid.is_valid[static_cast<std::size_t>(y * grid.n_columns + x)] = 0;
  const Vec3d a = at(3, 9, 700);
  const Vec3d b = at(40, 9, 500);
  const Vec3d c = at(30, 2, -100);
  const Vec3d d = at(30, 36, 300);
  for (const bool has_features : {false, true}) {
    TerrainLineOptions options{.breaklines = {{a, b}, {at(2, 4), at(44, 20)}}};
    if (has_features) options.least_relief = 2;
    const LinedTerrain one = add(grid, options);
    EXPECT_LT(gap_from(select_tin(one, 1e6), a, b), 1e-6);
    EXPECT_LT(gap_from(select_tin(one, 0), a, b), 1e-6);
    expect_passes(one, 3);
    options.breaklines = {{c, d}, {at(2, 25), at(44, 25)}};
    EXPECT_LT(gap_from(select_tin(add(grid, options), 2), c, d), 1e-6);
  }
}

TEST(terrain_lines, that_are_draped_leave_samples_as_they_are) {
  std::vector<Vec3d> points;
  for (const LatticePoint& p : delaunay::test::random_nodes(800, 90, 3))
    points.push_back(
        {{static_cast<double>(p.x), static_cast<double>(p.y), std::round(9 * ridges(p.x, p.y))}});
  Progress progress;
  const auto terrain = make_point_terrain(points, {{0, 0}, 1}, {}, {}, progress);
  ASSERT_TRUE(terrain);
  TerrainLineOptions options;
  for (int i = 0; i < 12; ++i)
    options.breaklines.push_back({{{10.0 + i, 12, kNaN}}, {{80.0 - 3 * i, 70.0 + i, kNaN}}});
  const LinedTerrain made = add(*terrain, options);
  EXPECT_EQ(made.report.n_replaced, 0);
  const TerrainTin tin = select_tin(made, 0);
  std::vector<Place> places;
  for (const Vec3d& p : points) places.push_back({{p[0], p[1]}});
  std::vector<TerrainHeight> heights(places.size());
  ASSERT_TRUE(tin.heights(places, heights, {}, progress));
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_NEAR(heights[i].height, points[i][2], 1e-9);
}

/// Half of it is there, at least, whichever corner it is cut at.
TEST(terrain_lines, that_graze_a_hole_keep_both_sides) {
  HeightGrid grid = raster();
  grid.is_valid.assign(static_cast<std::size_t>(grid.n_samples()), 1);
  for (int y = 20; y < 28; ++y)
    for (int x = 20; x < 28; ++x)
      grid.is_valid[static_cast<std::size_t>(y * grid.n_columns + x)] = 0;
  for (const double part : {10, 51, 102, 205, 307, 717}) {
    const double beyond = part / 1024;  // On the lattice.
    SCOPED_TRACE(beyond);
    // Past the corner of what is there no more, column 19, row 19.
    const double sum = 38 + beyond;
    const Vec3d a = at(sum - 2, 2, 50);
    const Vec3d b = at(2, sum - 2, 90);
    const LinedTerrain made = add(grid, {.breaklines = {{a, b}}});
    const TerrainTin tin = select_tin(made, 1e6);
    for (const auto& [from, to] : {std::pair{0.0, 0.4}, {0.6, 1.0}}) {
      const Vec3d p = a * (1 - from) + b * from;
      const Vec3d q = a * (1 - to) + b * to;
      EXPECT_LT(gap_from(tin, p, q), 1);
    }
    expect_passes(made, 2);
  }
}

TEST(terrain_lines, on_the_border_but_for_rounding_are_on_it) {
  const HeightGrid grid = raster();
  const Vec3d a = at(3, -1e-9, 70);
  const Vec3d b = at(40, -1e-9, 90);
  const LinedTerrain made = add(grid, {.breaklines = {{a, b}}});
  EXPECT_EQ(made.report.n_outside + made.report.n_cut, 0);
  EXPECT_EQ(made.report.n_replaced, 38);
  const LinedTerrain ring =
      add(grid, {.breaklines = {{at(0, 0), at(47, 0), at(47, 38), at(0, 38), at(0, 0)}}});
  EXPECT_EQ(ring.report.n_outside + ring.report.n_cut, 0);
}

TEST(terrain_lines, that_cross_meet_in_a_vertex) {
  const HeightGrid grid = raster();
  const LinedTerrain made = add(grid, {.breaklines = {{at(5, 5, 10), at(35, 30, 10)},
                                                      {at(5, 30, 10), at(35, 5, 10)},
                                                      {at(20, 2, 10), at(20, 36, 10)},
                                                      {at(5, 5, 10), at(35, 30, 10)}}});
  EXPECT_EQ(made.report.n_crossing, 0);
  // Three lines through one place, or nearly.
  EXPECT_GE(made.report.n_edges, 6);
  EXPECT_LE(made.report.n_edges, 9);
  for (const double max_error : {0.0, 8.0, 1e6}) expect_passes(made, max_error);
}

TEST(terrain_lines, outside_of_the_domain_are_left_out_or_cut) {
  HeightGrid grid = raster();
  grid.is_valid.assign(static_cast<std::size_t>(grid.n_samples()), 1);
  for (int y = 10; y < 20; ++y)
    for (int x = 10; x < 20; ++x)
      grid.is_valid[static_cast<std::size_t>(y * grid.n_columns + x)] = 0;
  const LinedTerrain made =
      add(grid, {.least_relief = 10,
                 .breaklines = {{at(-3e11, 5, 1), at(-2, 7, 2)},        // beside
                                {at(12, 12, 1), at(17, 17, 2)},         // in the hole
                                {at(2, 15.3, 100), at(40, 15.6, 100)},  // across it
                                {at(-5e9, 30), at(6e9, 33)},            // through it all
                                {at(4, 4, 7)}}});                       // no line at all
  EXPECT_EQ(made.report.n_breaklines, 5);
  EXPECT_EQ(made.report.n_outside, 3);
  EXPECT_EQ(made.report.n_cut, 2);
  EXPECT_EQ(made.report.n_crossing, 0);
  EXPECT_EQ(made.terrain.n_missing, 100);
  for (const double max_error : {0.0, 6.0, 1e6}) expect_passes(made, max_error);
}

TEST(terrain_lines, of_scattered_points_are_edges) {
  std::vector<Vec3d> points;
  for (const LatticePoint& p : delaunay::test::random_nodes(1500, 9000, 3))
    points.push_back({{p.x * 0.01, p.y * 0.01, ridges(p.x * 0.01, p.y * 0.01)}});
  Progress progress;
  const auto terrain = make_point_terrain(points, {{0, 0}, 0.01}, {}, {}, progress);
  ASSERT_TRUE(terrain);
  const LinedTerrain made = add(*terrain, {.least_relief = 8,
                                           .breaklines = {{{{20, 30, 5}}, {{70, 55, 90}}},
                                                          {{{-40, 10, kNaN}}, {{200, 80, kNaN}}},
                                                          {{{300, 10, 4}}, {{400, 80, 5}}}}});
  EXPECT_EQ(made.report.n_outside, 1);
  EXPECT_EQ(made.report.n_cut, 1);
  for (const double max_error : {0.0, 6.0, 1e6}) expect_passes(made, max_error);
}

/// Many lines at random, so that they cross, touch and run through samples.
TEST(terrain_lines, at_random_are_edges_within_the_error) {
  oracles::Random random(5);
  for (int trial = 0; trial < 6; ++trial) {
    SCOPED_TRACE(trial);
    const HeightGrid grid = raster(25, 22);
    TerrainLineOptions options{.is_draped = trial % 2 == 0, .drape_error = 3};
    if (trial % 3 == 0) options.least_relief = 12;
    const double step = trial < 3 ? 0.5 : 0.001;
    for (int i = 0; i < 25; ++i) {
      PlaceLine line;
      const auto n = 2 + random.below(4);
      for (std::uint64_t k = 0; k < n; ++k)
        line.push_back(at(step * std::round(random.uniform(-3, 27) / step),
                          step * std::round(random.uniform(-3, 24) / step),
                          random.uniform(-30, 30)));
      options.breaklines.push_back(line);
    }
    const LinedTerrain made = add(grid, options);
    EXPECT_EQ(made.report.n_crossing, 0);
    for (const double max_error : {0.0, 5.0}) expect_passes(made, max_error);
  }
}

TEST(terrain_lines, can_be_cancelled) {
  const HeightGrid grid = raster();
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(add_lines(grid, {.least_relief = 0}, progress));
}

}  // namespace
}  // namespace lode
