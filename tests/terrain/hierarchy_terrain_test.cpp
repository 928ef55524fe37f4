// Hierarchical triangulations as terrains that are built, kept in files and asked.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "lode/api/built_terrain.h"
#include "lode/api/terrain_tin.h"
#include "lode/mappers/tin_surface.h"
#include "lode/models/terrain/hierarchy_file/hierarchy_file.h"
#include "tests/terrain/hierarchy_fixtures.h"

namespace lode::test {
namespace {

class hierarchy_terrain : public testing::TestWithParam<TerrainModel> {
 protected:
  ~hierarchy_terrain() override {
    std::filesystem::remove(path_);
    std::filesystem::remove(other_);
  }
  BuiltTerrain build(const HeightGrid& grid, const std::vector<double>& levels) {
    auto made = BuiltTerrain::build(
        grid, {.model = GetParam(), .levels = levels, .sample_type = "int16"}, progress_);
    EXPECT_TRUE(made) << made.error().message;
    return *std::move(made);
  }
  BuiltTerrain reopened(const BuiltTerrain& made) {
    EXPECT_TRUE(made.save(path_, progress_));
    auto opened = BuiltTerrain::open(path_, progress_);
    EXPECT_TRUE(opened) << opened.error().message;
    return *std::move(opened);
  }
  /// Of the file with a lie.
  template <typename Tell>
  VerifyReport verify_lie(const HeightGrid& grid, const Tell& tell) {
    auto model = hierarchy_file::open(path_, progress_);
    tell(*model);
    EXPECT_TRUE(hierarchy_file::save(*model, other_, progress_));
    const auto opened = BuiltTerrain::open(other_, progress_);
    EXPECT_TRUE(opened) << opened.error().message;
    const auto report = opened->verify(grid, {2}, progress_);
    EXPECT_TRUE(report);
    return *report;
  }

  Progress progress_;
  const std::string path_ =
      testing::TempDir() + "lode_hierarchy_terrain_" + std::to_string(::getpid()) + ".lode";
  const std::string other_ =
      testing::TempDir() + "lode_hierarchy_terrain_lie_" + std::to_string(::getpid()) + ".lode";
};

HeightGrid placed(HeightGrid grid) {
  grid.to_world = {1000.5, 10, 0, 9e5, 0, -10};
  grid.vertical_unit = "metre";
  return grid;
}

std::string first_failure(const VerifyReport& report) {
  for (const VerifyReport::Check& check : report.checks)
    if (!check.passed) return check.name;
  return "";
}

TEST_P(hierarchy_terrain, is_true_of_the_hard_rasters_too) {
  for (TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const HeightGrid grid = placed(std::move(c.grid));
    const BuiltTerrain opened = reopened(build(grid, {150, 7, 0}));
    EXPECT_EQ(opened.model(), GetParam());
    EXPECT_EQ(opened.frame().n_columns, grid.n_columns);
    const auto report = opened.verify(grid, {2}, progress_);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(first_failure(*report), "");
    const auto alone = opened.verify_alone({2}, progress_);
    ASSERT_TRUE(alone);
    EXPECT_EQ(first_failure(*alone), "");
  }
}

TEST_P(hierarchy_terrain, has_heights_within_their_bounds_at_all_samples) {
  HeightGrid grid = placed(make_grid<std::int16_t>(38, 29, hills_with_spikes));
  for (std::int32_t x = 11; x < 15; ++x) delaunay::test::set_missing(grid, x, 8);
  const BuiltTerrain opened = reopened(build(grid, {150, 40, 0}));
  std::vector<Place> places;
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x) places.push_back(grid.world(x, y));
  for (const double max_error : {150.0, 45.0, 0.0}) {
    const auto tin = TerrainTin::select(opened.terrain(), {.max_error = max_error}, {}, progress_);
    ASSERT_TRUE(tin) << tin.error().message;
    EXPECT_LE(tin->report().achieved_error, max_error + rounding_of(grid));
    EXPECT_TRUE(tin->report().is_within_error);
    std::vector<TerrainHeight> heights;
    const auto found = tin->heights(places, heights, {2}, progress_);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->n_outside, 0U);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto x = static_cast<std::int32_t>(i) % grid.n_columns;
      const auto y = static_cast<std::int32_t>(i) / grid.n_columns;
      if (grid.has_height(x, y) && (y < 7 || y > 9)) {
        ASSERT_EQ(heights[i].where, TerrainHeight::Where::inside);
      }
      if (heights[i].where != TerrainHeight::Where::inside) continue;
      EXPECT_LE(std::abs(heights[i].height - grid.height(x, y)), heights[i].bound) << x << " " << y;
      // Heights in slivers of a node's width are rounded more: by 2^-53 of 1000 times 2^16.
      EXPECT_LE(heights[i].bound, max_error + 1e-8);
    }
  }
}

TEST_P(hierarchy_terrain, gives_the_same_mesh_from_memory_and_file) {
  const HeightGrid grid = placed(make_grid<float>(33, 27, hills_with_spikes));
  const BuiltTerrain made = build(grid, {150, 40, 7});
  const BuiltTerrain opened = reopened(made);
  for (const double max_error : {200.0, 40.0, 39.0, 7.0}) {
    const auto a = extract_terrain(made.terrain(), {.max_error = max_error}, progress_);
    const auto b = extract_terrain(opened.terrain(), {.max_error = max_error}, progress_);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->surface.triangles, b->surface.triangles);
    EXPECT_EQ(a->surface.positions, b->surface.positions);
    EXPECT_EQ(a->surface.values, b->surface.values);
    EXPECT_EQ(b->report.n_samples, 33U * 27U);
    EXPECT_LE(b->report.position_slack, 1e-4);
  }
}

TEST_P(hierarchy_terrain, has_the_finest_level_that_fits) {
  const HeightGrid grid = placed(make_grid<float>(33, 27, hills_with_spikes));
  const BuiltTerrain made = build(grid, {150, 40, 7});
  const auto info = made.describe(progress_);
  ASSERT_TRUE(info);
  ASSERT_EQ(info->levels.size(), 3U);
  const auto count = [&](const TerrainOptions& options) {
    return extract_terrain(made.terrain(), options, progress_)->report;
  };
  for (const auto& level : info->levels) {
    EXPECT_EQ(count({.max_error = level.tolerance}).triangles, level.triangles);
    EXPECT_EQ(count({.max_cells = level.triangles}).triangles, level.triangles);
  }
  EXPECT_EQ(count({.max_cells = info->levels[2].triangles - 1}).triangles,
            info->levels[1].triangles);
  const TerrainReport coarse = count({.max_cells = 1});
  EXPECT_EQ(coarse.triangles, info->levels[0].triangles);
  EXPECT_FALSE(coarse.budget_met);
  // Both: the tolerance where it fits.
  const TerrainReport both = count({.max_error = 40, .max_cells = 100'000});
  EXPECT_EQ(both.triangles, info->levels[1].triangles);
  EXPECT_TRUE(both.is_within_error);
  const TerrainReport less = count({.max_error = 7, .max_cells = info->levels[1].triangles});
  EXPECT_EQ(less.triangles, info->levels[1].triangles);
  EXPECT_FALSE(less.is_within_error);
  EXPECT_TRUE(less.budget_met);
}

/// As built, with the raster at hand, and as a file, without it.
TEST_P(hierarchy_terrain, varies) {
  const HeightGrid grid = placed(make_grid<float>(20, 20, hills_with_spikes));
  const BuiltTerrain made = build(grid, {150, 40});
  ASSERT_TRUE(made.save(path_, progress_));
  const auto opened = BuiltTerrain::open(path_, progress_);
  ASSERT_TRUE(opened) << opened.error().message;
  TerrainFocus focus;
  focus.boxes = {{{{1000, 9e5 - 60}}, {{1060, 9e5}}}};
  const auto uniform = extract_terrain(made.terrain(), {.max_error = 40}, progress_);
  ASSERT_TRUE(uniform);
  std::uint64_t measured = 0;
  for (const BuiltTerrain* terrain : {&made, &*opened}) {
    const auto varied =
        extract_terrain(terrain->terrain(), {.max_error = 40, .focus = focus}, progress_);
    ASSERT_TRUE(varied) << varied.error().message;
    EXPECT_FALSE(varied->report.is_uniform);
    EXPECT_LE(varied->report.achieved_error, 150 + 1e-9);
    EXPECT_LT(varied->report.triangles, uniform->report.triangles);
    EXPECT_GE(varied->report.triangles, measured);
    measured = varied->report.triangles;
  }
}

/// Not on those before it, after which more of the file may be in memory.
TEST_P(hierarchy_terrain, gives_answers_that_depend_on_the_question_alone) {
  const HeightGrid grid = placed(make_grid<std::int16_t>(65, 65, hills_with_spikes));
  const BuiltTerrain made = build(grid, {240, 24, 3});
  ASSERT_TRUE(made.save(path_, progress_));
  const auto opened = BuiltTerrain::open(path_, progress_);
  ASSERT_TRUE(opened) << opened.error().message;
  TerrainFocus focus;
  focus.boxes = {{{{1000, 9e5 - 900}}, {{1900, 9e5}}}};
  focus.max_error_outside = 240;
  const auto answer = [&](double tolerance) {
    return extract_terrain(opened->terrain(), {.max_error = tolerance, .focus = focus}, progress_)
        .value();
  };
  const auto first = answer(24);
  const auto finer = answer(3);
  const auto again = answer(24);
  EXPECT_LT(first.report.triangles, finer.report.triangles);
  EXPECT_EQ(first.surface.triangles, again.surface.triangles);
  EXPECT_EQ(first.surface.positions, again.surface.positions);
  // A tolerance that is a level's takes no triangles of the next one: what they say of themselves
  // is rounded up.
  const auto all = extract_terrain(opened->terrain(), {.max_error = 24}, progress_);
  ASSERT_TRUE(all);
  EXPECT_LE(first.report.triangles, all->report.triangles);
}

TEST_P(hierarchy_terrain, refuses_what_it_cannot_by_its_nature) {
  const HeightGrid grid = placed(make_grid<float>(20, 20, hills_with_spikes));
  const BuiltTerrain made = build(grid, {150, 40});
  const auto finer = extract_terrain(made.terrain(), {.max_error = 39}, progress_);
  ASSERT_FALSE(finer);
  EXPECT_NE(finer.error().message.find("40 or more"), std::string::npos) << finer.error().message;
  TerrainFocus focus;
  focus.boxes = {{{{1000, 9e5 - 60}}, {{1060, 9e5}}}};
  focus.max_error_outside = 39;
  EXPECT_FALSE(extract_terrain(made.terrain(), {.max_error = 40, .focus = focus}, progress_));
  HeightGrid none = make_grid<float>(5, 5, hills_with_spikes);
  for (std::int32_t y = 0; y < 5; ++y)
    for (std::int32_t x = 0; x < 5; ++x) delaunay::test::set_missing(none, x, y);
  EXPECT_FALSE(BuiltTerrain::build(none, {.model = GetParam(), .levels = {3}}, progress_));
}

TEST_P(hierarchy_terrain, is_found_out_where_it_lies) {
  const HeightGrid grid = placed(make_grid<float>(24, 21, hills_with_spikes));
  ASSERT_TRUE(build(grid, {150, 40, 7}).save(path_, progress_));
  EXPECT_EQ(first_failure(verify_lie(grid, [](auto&) {})), "");
  const auto expect_found = [&](const char* check, const auto& tell) {
    const std::string found = first_failure(verify_lie(grid, tell));
    EXPECT_NE(found.find(check), std::string::npos) << found << " instead of " << check;
  };
  const auto is_on_sample = [](const auto& h, std::size_t v) {
    return h.vertices[v].x % h.scale() == 0 && h.vertices[v].y % h.scale() == 0;
  };
  for (const bool on_samples : {true, false})
    expect_found("within 7: vertices are samples, or between two", [&](auto& m) {
      auto& h = m.hierarchy;
      for (std::size_t v = h.vertices_until[1]; v < h.vertices.size(); ++v)
        if (is_on_sample(h, v) == on_samples) {
          h.heights[v] += h.heights[v] > 0 ? -1e-9 : 1e-9;
          return;
        }
    });
  expect_found("state their errors", [](auto& m) {
    for (auto& triangle : m.hierarchy.triangles) triangle.error /= 2;
  });
  expect_found("within 11: samples are within the error", [](auto& m) {
    m.hierarchy.tolerances = {11, 10, 7};
    for (auto& triangle : m.hierarchy.triangles) triangle.error = 0;
  });
}

TEST_P(hierarchy_terrain, is_held_against_its_own_raster_alone) {
  HeightGrid grid = placed(make_grid<float>(24, 21, hills_with_spikes));
  const BuiltTerrain made = build(grid, {150, 40});
  EXPECT_FALSE(made.verify(make_grid<float>(24, 22, hills_with_spikes), {2}, progress_));
  delaunay::test::set_missing(grid, 12, 12);
  const auto report = made.verify(grid, {2}, progress_);
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->passed());
}

TEST(fine_surface, counts_triangles_that_floats_flatten) {
  delaunay::Tin tin;
  // x is 0, 8000000.67, which floats have as 8000000.5, and 16000001.
  tin.vertices = {{0, 0}, {24'000'002, 1}, {48'000'003, 2}, {0, 90}};
  tin.heights = {0, 0, 0, 0};
  tin.triangles = {{0, 1, 2}, {0, 2, 3}};
  ASSERT_EQ(delaunay::doubled_area(tin.vertices[0], tin.vertices[1], tin.vertices[2]), 1);
  HeightFrame frame;
  frame.to_world = {0, 1.0 / 3, 0, 0, 0, 1.0 / 3};
  EXPECT_EQ(to_surface(tin, frame).n_turned, 1U);
  frame.to_world[5] *= -1;
  EXPECT_EQ(to_surface(tin, frame).n_turned, 1U);
}

INSTANTIATE_TEST_SUITE_P(models, hierarchy_terrain,
                         testing::Values(TerrainModel::adaptive_triangulation,
                                         TerrainModel::hierarchical_delaunay),
                         [](const auto& model) { return name_of(model.param); });

}  // namespace
}  // namespace lode::test
