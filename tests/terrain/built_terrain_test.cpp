// Models that lie about their raster, and rasters that are hard to build one of.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

#include "lode/api/built_terrain.h"
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

}  // namespace
}  // namespace lode
