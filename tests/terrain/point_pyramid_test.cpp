// What is built of scattered points, and of rasters with lines, for all tolerances.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/built_terrain.h"
#include "lode/api/insertions_terrain.h"
#include "lode/api/terrain_lines.h"
#include "lode/api/terrain_selection.h"
#include "lode/mappers/point_errors.h"
#include "lode/mappers/tin_surface.h"
#include "lode/models/terrain/insertions/extract.h"
#include "lode/models/terrain/insertions/history_locator.h"
#include "lode/refine/focus.h"
#include "tests/oracles/random.h"
#include "tests/terrain/height_grids.h"
#include "tests/terrain/point_terrains.h"

namespace lode {
namespace {

using insertions::History;

constexpr std::array kModels{TerrainModel::delaunay_pyramid, TerrainModel::ternary_triangulation,
                             TerrainModel::implicit_delaunay_pyramid};

void expect_passed(const Result<VerifyReport>& report) {
  ASSERT_TRUE(report) << report.error().message;
  for (const VerifyReport::Check& check : report->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

History history_of(const PointTerrain& terrain, TerrainModel model, double max_error) {
  Progress progress;
  auto made = build_insertions(terrain, model, max_error, progress);
  EXPECT_TRUE(made) << made.error().message;
  return *std::move(made);
}

TEST(point_pyramid, holds_against_its_points_and_comes_back_from_files) {
  const std::string path =
      testing::TempDir() + "lode_point_pyramid_" + std::to_string(::getpid()) + ".lode";
  for (const test::PointCase& c : test::point_cases())
    for (const TerrainModel model : kModels) {
      SCOPED_TRACE(c.name + ", " + name_of(model));
      Progress progress;
      const auto made = BuiltTerrain::build(
          c.terrain, {.model = model, .levels = {30, 10, 1.5}, .sample_type = "points"}, progress);
      ASSERT_TRUE(made) << made.error().message;
      expect_passed(made->verify(c.terrain, {2}, progress));
      ASSERT_TRUE(made->save(path, progress));
      const auto opened = BuiltTerrain::open(path, progress);
      ASSERT_TRUE(opened) << opened.error().message;
      expect_passed(opened->verify(c.terrain, {1}, progress));
      EXPECT_TRUE(opened->describe_source().is_of_points);
      EXPECT_EQ(opened->describe_source().n_lines, made->describe_source().n_lines);
      EXPECT_EQ(opened->describe_source().n_lines > 0, !c.terrain.domain.lines.empty());
      for (const double tolerance : {100.0, 12.0, 1.5}) {
        const auto a = extract_terrain(made->terrain(), {.max_error = tolerance}, progress);
        const auto b = extract_terrain(opened->terrain(), {.max_error = tolerance}, progress);
        ASSERT_TRUE(a && b);
        EXPECT_EQ(a->surface.positions, b->surface.positions);
        EXPECT_EQ(a->surface.triangles, b->surface.triangles);
      }
      const double finest = opened->describe_source().max_error;
      EXPECT_LE(finest, 1.5);
      if (finest > 0)
        EXPECT_FALSE(extract_terrain(opened->terrain(), {.max_error = finest / 2}, progress));
    }
  std::filesystem::remove(path);
}

/// But for errors, which are kept with 8 bits: so it may be a few insertions finer.
TEST(point_pyramid, is_the_strict_selector_at_all_tolerances) {
  for (const test::PointCase& c : test::point_cases()) {
    SCOPED_TRACE(c.name);
    Progress progress;
    const History history = history_of(c.terrain, TerrainModel::delaunay_pyramid, 0.5);
    for (const double tolerance : {60.0, 11.0, 0.5}) {
      const auto selected =
          select_terrain(c.terrain, {.max_error = tolerance, .order = InsertionOrder::strict},
                         delaunay::TinLinks::left_out, progress);
      ASSERT_TRUE(selected);
      const std::uint32_t time = time_within(history, tolerance);
      const std::size_t n_own = history.n_base_vertices + time;
      const std::size_t n_theirs = selected->tin.vertices.size();
      EXPECT_GE(n_own, n_theirs);
      EXPECT_LE(n_own, n_theirs + n_theirs / 50 + 2);
      const delaunay::Tin same =
          tin_at(history, static_cast<std::uint32_t>(n_theirs) - history.n_base_vertices,
                 delaunay::TinLinks::left_out);
      EXPECT_EQ(same.vertices, selected->tin.vertices);
    }
  }
}

/// Levels lose a fraction each, and what is on lines comes first.
TEST(point_pyramid, of_all_points_has_logarithmically_many_levels) {
  const History history =
      history_of(test::scattered(4000, 100'000, 6), TerrainModel::implicit_delaunay_pyramid, 0);
  EXPECT_EQ(history.vertices.size(), 4000U);
  EXPECT_EQ(history.max_error, 0);
  EXPECT_LT(history.level_ends.size(), 40U);
  EXPECT_GT(history.level_ends.size(), 8U);
  const test::PointCase lined = test::point_cases()[4];
  ASSERT_EQ(lined.name, "lines");
  const History with_lines = history_of(lined.terrain, TerrainModel::implicit_delaunay_pyramid, 0);
  std::size_t n_points = 0;
  for (const std::uint32_t t : lined.terrain.domain.triangle_of)
    n_points += t != delaunay::kNoHalfEdge ? 1 : 0;
  EXPECT_EQ(with_lines.vertices.size(), n_points);
}

/// Each node with a chance of one in `n`, and all that these depend on.
insertions::AppliedNodes random_set(const History& history, oracles::Random& random,
                                    std::size_t n) {
  insertions::AppliedNodes applied(history.n_nodes());
  for (std::uint32_t node = history.n_nodes(); node-- > 0;) {
    if (!applied[node] && random.below(n) > 0) continue;
    applied[node] = true;
    for (const std::uint32_t t : history.removed_by(node))
      if (history.birth(t) != insertions::kNone) applied[history.birth(t)] = true;
  }
  return applied;
}

/// Conforming, of the domain, constrained Delaunay where that is the rule, with all lines.
TEST(point_pyramid, any_mixture_keeps_domain_and_lines) {
  oracles::Random random(7);
  for (const test::PointCase& c : test::point_cases())
    for (const TerrainModel model : kModels) {
      SCOPED_TRACE(c.name + ", " + name_of(model));
      Progress progress;
      const History history = history_of(c.terrain, model, 0.5);
      for (const std::size_t n : {300, 60, 12, 3}) {
        const delaunay::Tin tin =
            tin_of(history, random_set(history, random, n), delaunay::TinLinks::left_out);
        const Surface surface = to_surface(tin, history.frame).surface;
        expect_passed(verify_terrain(c.terrain, surface,
                                     {.max_error = 1e9, .shape = shape_of(model)}, progress));
      }
    }
}

/// By all points, also those on edges, in all triangles.
TEST(point_pyramid, keeps_tolerances_that_vary_at_all_points) {
  for (const test::PointCase& c : test::point_cases())
    for (const TerrainModel model : kModels) {
      SCOPED_TRACE(c.name + ", " + name_of(model));
      const HeightPoints& points = c.terrain.points;
      const History history = history_of(c.terrain, model, 0.5);
      const Vec<double, 2> low = points.world(0.3 * points.n_columns, 0.2 * points.n_rows);
      const Vec<double, 2> high = points.world(0.5 * points.n_columns, 0.45 * points.n_rows);
      const Demand demand =
          FocusDemand{.foci = {BoxFocus{{{{low[0], low[1], -1e9}}, {{high[0], high[1], 1e9}}}}},
                      .inside = 1,
                      .outside = 40};
      const delaunay::Tin tin =
          tin_of(history, select_nodes(history, demand), delaunay::TinLinks::left_out);
      delaunay::Tin inside = tin;
      std::erase_if(inside.triangles, [&](const auto& corner) {
        std::array<double, 2> least{1e300, 1e300};
        std::array<double, 2> most{-1e300, -1e300};
        for (const std::uint32_t v : corner) {
          const auto at = points.world(tin.vertices[v].x, tin.vertices[v].y);
          for (std::size_t i = 0; i < 2; ++i) {
            least[i] = std::min(least[i], at[i]);
            most[i] = std::max(most[i], at[i]);
          }
        }
        return least[0] > high[0] || most[0] < low[0] || least[1] > high[1] || most[1] < low[1];
      });
      // What is stated is what is asked for; so these count all that do not keep it.
      Progress progress;
      for (const delaunay::Tin* part : {&tin, static_cast<const delaunay::Tin*>(&inside)}) {
        delaunay::Tin stated = *part;
        stated.errors.assign(stated.triangles.size(), part == &tin ? 40.0F : 1.0F);
        const auto n_beyond = count_understated_points(stated, points, {}, progress);
        ASSERT_TRUE(n_beyond);
        EXPECT_EQ(*n_beyond, 0U);
      }
    }
}

/// A height at every point, from the mesh found down the history, is that of a search of all.
TEST(point_pyramid, finds_points_beside_lines) {
  for (const test::PointCase& c : test::point_cases()) {
    SCOPED_TRACE(c.name);
    const History history = history_of(c.terrain, TerrainModel::delaunay_pyramid, 0.5);
    const insertions::HistoryLocator locator(history);
    const insertions::NodeSet nodes(history.n_nodes() / 2);
    const HeightPoints& points = c.terrain.points;
    for (std::size_t i = 0; i < points.nodes.size(); i += 3) {
      const LatticePoint p = points.nodes[i];
      const auto found =
          locator.find(nodes, {{static_cast<double>(p.x), static_cast<double>(p.y)}});
      ASSERT_EQ(found.has_value(), c.terrain.domain.triangle_of[i] != delaunay::kNoHalfEdge);
      if (!found) continue;
      const insertions::Triangle& triangle = history.triangles[*found];
      EXPECT_TRUE(history.birth(*found) == insertions::kNone || nodes.has(history.birth(*found)));
      EXPECT_FALSE(nodes.has(triangle.death));
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_GE(delaunay::doubled_area(history.vertices[triangle.corner[k]],
                                         history.vertices[triangle.corner[(k + 1) % 3]], p),
                  0);
    }
  }
}

/// An implicit pyramid has its own.
std::vector<double> levels_for(const History& history, std::vector<double> levels) {
  return history.is_worst_first() ? std::move(levels) : std::vector<double>{};
}

/// The first check that fails, or "".
std::string failed(const InsertionsTerrain& model, const PointTerrain& terrain) {
  Progress progress;
  const auto report = model.verify(terrain, {}, progress);
  EXPECT_TRUE(report) << report.error().message;
  for (const VerifyReport::Check& check : report->checks)
    if (!check.passed) return check.name;
  return "";
}

TEST(point_pyramid, lies_are_found) {
  const PointTerrain terrain = test::scattered(400, 5000, 9);
  const History whole = history_of(terrain, TerrainModel::delaunay_pyramid, 1);
  const auto with = [&](const auto& change) {
    History history = whole;
    change(history);
    return failed(InsertionsTerrain({std::move(history), {30, 1}}), terrain);
  };
  EXPECT_EQ(with([](History&) {}), "");
  EXPECT_EQ(with([](History& h) { h.n_samples += 1; }),
            "the file says of the points what they are");
  EXPECT_EQ(with([](History& h) { h.heights[5] += 0.25; }), "vertices have the points' heights");
  EXPECT_EQ(with([](History& h) { h.max_error *= 0.5; }).rfind("within 0.", 0), 0U);
  // One that is not the worst when it dies, so that levels are what they were.
  EXPECT_EQ(with([](History& h) {
              const auto is_lesser = [&](const insertions::Triangle& t) {
                return t.death != insertions::kNone && t.error > 1 &&
                       t.error < h.error_before(t.death) / 2;
              };
              const auto lesser = std::ranges::find_if(h.triangles, is_lesser);
              ASSERT_NE(lesser, h.triangles.end());
              lesser->error /= 2;
            }),
            "triangles of all times state their errors");
  Progress progress;
  const HeightGrid grid =
      test::float_grid(9, 9, [](int x, int y) { return test::rough_hills(x, y); });
  EXPECT_FALSE(InsertionsTerrain({whole, {}}).verify(grid, {}, progress));
  const auto of_raster = build_insertions(grid, TerrainModel::delaunay_pyramid, 1, progress);
  ASSERT_TRUE(of_raster);
  EXPECT_FALSE(InsertionsTerrain({*of_raster, {}}).verify(terrain, {}, progress));
}

TEST(point_pyramid, of_other_lines_is_found_out) {
  const HeightGrid grid =
      test::float_grid(31, 24, [](int x, int y) { return test::rough_hills(2 * x, 2 * y); });
  Progress progress;
  const auto many = add_lines(grid, {.least_relief = 5}, progress);
  const auto few = add_lines(grid, {.least_relief = 40}, progress);
  ASSERT_TRUE(many && few);
  for (const TerrainModel model : kModels) {
    SCOPED_TRACE(name_of(model));
    const History history = history_of(many->terrain, model, 1);
    const std::vector<double> levels = levels_for(history, {30, 1});
    EXPECT_EQ(failed(InsertionsTerrain({history, levels}), many->terrain), "");
    EXPECT_EQ(failed(InsertionsTerrain({history, levels}), few->terrain),
              "fixed edges are those of the lines");
  }
}

/// Heights that float32 does not hold, and no error but rounding; and a lattice of 2^26 nodes a
/// side, whose points are nearer to each other than floats tell.
TEST(point_pyramid, holds_where_floats_do_not_tell) {
  std::vector<Vec3d> plane;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x)
      plane.push_back({{x + 0.25 * y, y + 0.125 * x, 1000 + 0.01 * x + 0.03 * y}});
  std::vector<Vec3d> fine;
  oracles::Random random(3);
  for (int i = 0; i < 300; ++i) {
    const double x = 0.001 * static_cast<double>(random.below(60'000'000));
    const double y = 0.001 * static_cast<double>(random.below(60'000'000));
    const double z = std::round(test::rough_hills(x / 1000, y / 1000));
    for (const double step : {0.0, 0.001, 0.002}) fine.push_back({{x + step, y + 2 * step, z}});
  }
  for (const auto& [points, lattice] :
       {std::pair{plane, PointLattice{{0, 0}, 0.125}}, {fine, PointLattice{{0, 0}, 0.001}}}) {
    Progress progress;
    const auto terrain = make_point_terrain(points, lattice, {}, {}, progress);
    ASSERT_TRUE(terrain) << terrain.error().message;
    for (const TerrainModel model : kModels) {
      const History history = history_of(*terrain, model, 0.005);
      EXPECT_EQ(failed(InsertionsTerrain({history, levels_for(history, {5, 0.005})}), *terrain),
                "");
    }
  }
}

/// Draped vertices are beside it by rounding, and edges between these outside.
TEST(point_pyramid, lines_along_an_oblique_outline_are_whole_or_told) {
  std::vector<Vec3d> points{{{0, 0, 5}}, {{997, 313, 40}}, {{683, 1009, 10}}, {{-314, 696, 80}}};
  oracles::Random random(8);
  for (int i = 0; i < 200; ++i) {
    const double s = random.uniform(0.01, 0.99);
    const double t = random.uniform(0.01, 0.99);
    points.push_back({{std::round(997 * s - 314 * t), std::round(313 * s + 696 * t),
                       std::round(test::rough_hills(30 * s, 30 * t))}});
  }
  Progress progress;
  const auto terrain = make_point_terrain(points, {{0, 0}, 1}, {}, {}, progress);
  ASSERT_TRUE(terrain);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  TerrainLineOptions lines{.drape_error = 0.5};
  lines.breaklines.push_back(
      {{{{0, 0, kNaN}}, {{997, 313, kNaN}}, {{683, 1009, kNaN}}, {{100, 500, kNaN}}}});
  const auto lined = add_lines(*terrain, lines, progress);
  ASSERT_TRUE(lined) << lined.error().message;
  for (const TerrainModel model : kModels) {
    const History history = history_of(lined->terrain, model, 1);
    EXPECT_EQ(failed(InsertionsTerrain({history, levels_for(history, {30, 1})}), lined->terrain),
              "");
  }
}

/// Of the selector's triangles, too, that of a point on an edge on both sides.
TEST(point_pyramid, triangles_state_errors_of_points_on_edges) {
  for (const test::PointCase& c : test::point_cases())
    for (const InsertionOrder order : {InsertionOrder::levels, InsertionOrder::strict}) {
      SCOPED_TRACE(c.name);
      Progress progress;
      for (const double max_error : {3.0, 25.0}) {
        const auto made = select_terrain(c.terrain, {.max_error = max_error, .order = order},
                                         delaunay::TinLinks::kept, progress);
        ASSERT_TRUE(made);
        const auto n = count_understated_points(made->tin, c.terrain.points, {}, progress);
        ASSERT_TRUE(n);
        EXPECT_EQ(*n, 0U);
        for (const float error : made->tin.errors)
          EXPECT_LE(static_cast<double>(error), max_error * (1 + 0x1p-20));
      }
    }
}

/// Two triangles over the edge from (0, 0) to (4, 4), with a point on it, and one in each.
TEST(point_errors, are_those_of_points_on_edges_too) {
  HeightPoints points;
  points.n_columns = points.n_rows = 5;
  points.nodes = {{0, 0}, {4, 0}, {3, 1}, {2, 2}, {1, 3}, {0, 4}, {4, 4}};
  points.heights = {0, 0, 2, 5, -6, 0, 0};
  delaunay::Tin tin;
  tin.vertices = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  tin.heights = {0, 0, 0, 0};
  tin.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto count = [&](float below, float above) {
    tin.errors = {below, above};
    Progress progress;
    const auto n = count_understated_points(tin, points, {}, progress);
    EXPECT_TRUE(n);
    return *n;
  };
  EXPECT_EQ(count(5, 6), 0U);
  EXPECT_EQ(count(4, 6), 1U);
  EXPECT_EQ(count(5, 5), 1U);
  EXPECT_EQ(count(2, 3), 2U);
}

}  // namespace
}  // namespace lode
