// Models that lie about their raster, and rasters that are hard to build one of.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

#include "lode/api/built_terrain.h"
#include "lode/api/terrain_sight.h"
#include "lode/api/terrain_tin.h"
#include "lode/models/terrain/insertions/build.h"
#include "lode/models/terrain/insertions/persist.h"
#include "tests/terrain/height_grids.h"

namespace lode {
namespace {

using insertions::LevelledHistory;
using insertions::Model;

double gentle_waves(int x, int y) {
  return 30 * std::sin(0.3 * x) * std::cos(0.2 * y) + 0.25 * (x % 3);
}

/// Whether verify() passes once a model has been changed, and saved with checksums that are
/// right.
bool passes(const std::function<void(LevelledHistory&)>& change,
            Model model = Model::delaunay_pyramid) {
  const HeightGrid grid = test::float_grid(30, 22, gentle_waves);
  Progress progress;
  auto history = insertions::build_history(grid, 0.5, model, progress);
  EXPECT_TRUE(history);
  LevelledHistory made{*std::move(history), {8, 0.5}};
  change(made);
  const std::string path = testing::TempDir() + "lode_lie.lode";
  EXPECT_TRUE(insertions::save(made, path, progress));
  const auto opened = BuiltTerrain::open(path, progress);
  std::filesystem::remove(path);
  if (!opened) return false;
  const auto report = opened->verify(grid, {2}, progress);
  return report && report->passed();
}

TEST(built_terrain, finds_what_is_not_so) {
  EXPECT_TRUE(passes([](LevelledHistory&) {}));
  EXPECT_TRUE(passes([](LevelledHistory&) {}, Model::ternary_triangulation));
  // Triangles that are split say that they are Delaunay.
  EXPECT_FALSE(passes([](LevelledHistory& p) { p.history.model = Model::delaunay_pyramid; },
                      Model::ternary_triangulation));
  const auto no_errors = [](LevelledHistory& p) {
    for (auto& triangle : p.history.triangles) triangle.error = 0;
  };
  EXPECT_FALSE(passes(no_errors));
  EXPECT_FALSE(passes(no_errors, Model::ternary_triangulation));
  EXPECT_FALSE(passes([&](LevelledHistory& p) {
    no_errors(p);
    p.levels = {1e6};
    p.history.range.lower = -1e17;
  }));
  EXPECT_FALSE(passes([](LevelledHistory& p) {
    p.levels.clear();
    for (std::size_t v = p.history.n_base_vertices; v < p.history.heights.size(); ++v)
      p.history.heights[v] = -p.history.heights[v];
    for (auto& triangle : p.history.triangles) triangle.error = 1e4F;
    p.history.range = {-40, 40};
  }));
  EXPECT_FALSE(passes([](LevelledHistory& p) { p.history.max_error = 0; }));
  EXPECT_FALSE(passes([](LevelledHistory& p) { p.history.frame.crs = "elsewhere"; }));
  EXPECT_FALSE(passes([](LevelledHistory& p) { p.history.frame.vertical_unit = "furlong"; }));
  EXPECT_FALSE(passes([](LevelledHistory& p) { p.history.n_left_out = 77; }));
  EXPECT_FALSE(passes([](LevelledHistory& p) { p.history.range.upper = 1e20; }));
}

TEST(built_terrain, of_doubles_is_held_against_them_and_not_against_floats) {
  HeightGrid grid = make_height_grid<double>(21, 17);
  auto& heights = std::get<HeightGrid::Samples<double>>(grid.heights);
  for (int y = 0; y < 17; ++y)
    for (int x = 0; x < 21; ++x)
      heights[static_cast<std::size_t>(y * grid.stride + x)] = 1000 + gentle_waves(x, y) / 7;
  Progress progress;
  for (const TerrainModel model : kBuiltTerrainModels) {
    SCOPED_TRACE(name_of(model));
    const auto made = BuiltTerrain::build(grid, {.model = model, .levels = {1, 1e-9}}, progress);
    ASSERT_TRUE(made) << made.error().message;
    const auto report = made->verify(grid, {2}, progress);
    ASSERT_TRUE(report) << report.error().message;
    for (const VerifyReport::Check& check : report->checks)
      EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  }
}

TEST(built_terrain, builds_what_is_hard_or_says_why_not) {
  Progress progress;
  HeightGrid grid = make_height_grid<double>(9, 8);
  auto& heights = std::get<HeightGrid::Samples<double>>(grid.heights);
  const auto build = [&](const std::function<double(int)>& height) {
    for (std::size_t i = 0; i < heights.size(); ++i) heights[i] = height(static_cast<int>(i));
    return BuiltTerrain::build(grid, {}, progress);
  };
  const auto huge = build([](int i) { return i % 2 == 0 ? 1.7e308 : -1.7e308; });
  ASSERT_FALSE(huge);
  EXPECT_NE(huge.error().message.find("expected heights"), std::string::npos);
  const auto denormal =
      build([](int i) { return std::numeric_limits<double>::denorm_min() * (i % 5); });
  ASSERT_TRUE(denormal);
  EXPECT_EQ(denormal->describe(progress)->levels.size(), 1U);
  const auto flat = build([](int) { return 3.0; });
  ASSERT_TRUE(flat);
  EXPECT_EQ(flat->describe(progress)->levels[0].triangles, 2U);
}

TEST(built_terrain, default_levels_halve_from_below_the_range) {
  const std::vector<double> levels = default_levels({.lower = 0, .upper = 2000});
  EXPECT_EQ(levels.front(), 1024);
  EXPECT_EQ(levels.back(), 1);
  for (std::size_t i = 1; i < levels.size(); ++i) EXPECT_EQ(levels[i], levels[i - 1] / 2);
  EXPECT_EQ(default_levels({}), std::vector<double>{0});
}

void expect_same(const std::vector<TerrainHeight>& a, const std::vector<TerrainHeight>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].where, b[i].where);
    EXPECT_EQ(a[i].height, b[i].height);
    EXPECT_EQ(a[i].bound, b[i].bound);
  }
}

void expect_same(const TerrainReport& a, const TerrainReport& b) {
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.max_error, b.max_error);
  EXPECT_EQ(a.achieved_error, b.achieved_error);
  EXPECT_EQ(a.is_within_error, b.is_within_error);
  EXPECT_EQ(a.budget_met, b.budget_met);
  EXPECT_EQ(a.n_samples, b.n_samples);
}

/// Heights, profile and sight of a terrain, by TINs of the whole or of what is near.
struct Answers {
  TerrainReport report;
  std::vector<TerrainHeight> heights;
  TerrainProfile profile;
  TerrainSight sight;
};

Answers ask(const Terrain& terrain, double max_error, TinUse use) {
  Progress progress;
  Answers answers;
  const auto tin = TerrainTin::select(terrain, {.max_error = max_error}, {}, progress, use);
  EXPECT_TRUE(tin);
  answers.report = tin->report();
  std::vector<Place> places;
  for (int i = 0; i < 200; ++i) places.push_back({{(i * 37 % 130) * 0.5 - 3, (i * 53 % 90) * 0.5}});
  EXPECT_TRUE(tin->heights(places, answers.heights, {2}, progress));
  const auto profile = tin->profile({{1, 2.5}}, {{55.25, 40}}, progress);
  EXPECT_TRUE(profile);
  answers.profile = *profile;
  const auto sight = tin->sight({.from = {{2, 3}}, .to = {{50, 30}}}, progress);
  EXPECT_TRUE(sight) << sight.error().message;
  answers.sight = *sight;
  return answers;
}

TEST(built_terrain, answers_from_a_file_as_from_memory) {
  const HeightGrid grid = test::float_grid(60, 45, gentle_waves);
  Progress progress;
  const std::string path = testing::TempDir() + "lode_answers.lode";
  for (const TerrainModel model :
       {TerrainModel::delaunay_pyramid, TerrainModel::ternary_triangulation,
        TerrainModel::implicit_delaunay_pyramid, TerrainModel::complete_pyramid,
        TerrainModel::triangle_lists, TerrainModel::linked_triangle_lists}) {
    SCOPED_TRACE(name_of(model));
    const auto built = BuiltTerrain::build(grid, {.model = model, .levels = {8, 2, 0.5}}, progress);
    ASSERT_TRUE(built);
    ASSERT_TRUE(built->save(path, progress));
    const auto opened = BuiltTerrain::open(path, progress);
    ASSERT_TRUE(opened) << opened.error().message;
    for (const double max_error : {40.0, 8.0, 1.0, 0.5}) {
      const Answers want = ask(built->terrain(), max_error, TinUse::all);
      const Answers got = ask(opened->terrain(), max_error, TinUse::places);
      expect_same(got.report, want.report);
      expect_same(got.heights, want.heights);
      ASSERT_EQ(got.profile.points.size(), want.profile.points.size());
      for (std::size_t i = 0; i < got.profile.points.size(); ++i) {
        EXPECT_EQ(got.profile.points[i].height, want.profile.points[i].height);
        EXPECT_EQ(got.profile.points[i].bound, want.profile.points[i].bound);
      }
      EXPECT_EQ(got.sight.verdict, want.sight.verdict);
      EXPECT_EQ(got.sight.above_low, want.sight.above_low);
    }
    for (const TerrainOptions& options :
         {TerrainOptions{.max_error = 2}, TerrainOptions{.max_cells = 300},
          TerrainOptions{.max_error = 1, .max_cells = 100},
          TerrainOptions{.max_error = 0.5,
          .focus = TerrainFocus{.boxes = {{{{5, 5}}, {{12, 20}}}}}}}) {
      const auto want = extract_terrain(built->terrain(), options, progress);
      const auto got = extract_terrain(opened->terrain(), options, progress);
      ASSERT_TRUE(want && got);
      expect_same(got->report, want->report);
      EXPECT_EQ(got->surface.triangles, want->surface.triangles);
      EXPECT_EQ(got->surface.positions, want->surface.positions);
    }
    const auto said = opened->describe(progress);
    const auto made = built->describe(progress);
    ASSERT_TRUE(said && made);
    EXPECT_EQ(said->memory_bytes, made->memory_bytes);
    ASSERT_EQ(said->levels.size(), made->levels.size());
    for (std::size_t i = 0; i < said->levels.size(); ++i) {
      EXPECT_EQ(said->levels[i].tolerance, made->levels[i].tolerance);
      EXPECT_EQ(said->levels[i].triangles, made->levels[i].triangles);
      EXPECT_EQ(said->levels[i].vertices, made->levels[i].vertices);
      EXPECT_EQ(said->levels[i].median_angle, made->levels[i].median_angle);
    }
    const auto report = opened->verify(grid, {2}, progress);
    ASSERT_TRUE(report);
    EXPECT_TRUE(report->passed());
  }
  std::filesystem::remove(path);
}

TEST(built_terrain, finds_figures_of_levels_that_are_not_so) {
  EXPECT_FALSE(passes([](LevelledHistory& p) {
    Progress progress;
    p.facts = *insertions::find_facts(p, progress);
    ++p.facts[0].n_vertices;
  }));
}

}  // namespace
}  // namespace lode
