// Delaunay pyramids that are kept by levels, as terrains that are built, kept in files and asked.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lode/api/built_terrain.h"
#include "lode/api/files.h"
#include "lode/api/terrain_focus.h"
#include "lode/api/terrain_tin.h"
#include "tests/terrain/point_terrains.h"

namespace lode::test {
namespace {

const std::vector<double> kTolerances{40, 12, 3, 0.5};

class pyramid_terrain : public testing::TestWithParam<TerrainModel> {
 protected:
  ~pyramid_terrain() override { std::filesystem::remove(path_); }

  template <typename Ground>
  BuiltTerrain build(const Ground& ground, TerrainModel model,
                     const std::vector<double>& levels = kTolerances) {
    auto made = BuiltTerrain::build(ground, {.model = model, .levels = levels}, progress_);
    EXPECT_TRUE(made) << made.error().message;
    return *std::move(made);
  }
  BuiltTerrain reopened(const BuiltTerrain& made) {
    EXPECT_TRUE(made.save(path_, progress_));
    auto opened = BuiltTerrain::open(path_, progress_);
    EXPECT_TRUE(opened) << opened.error().message;
    return *std::move(opened);
  }
  /// From memory and from a file as from the history, at each level.
  template <typename Ground>
  void expect_meshes_of_the_pyramid(const Ground& ground, const std::vector<double>& levels) {
    const BuiltTerrain history = build(ground, TerrainModel::delaunay_pyramid, levels);
    const BuiltTerrain made = build(ground, GetParam(), levels);
    const BuiltTerrain opened = reopened(made);
    for (const double tolerance : levels) {
      const TerrainOptions options{.max_error = tolerance};
      const auto wanted = extract_terrain(history.terrain(), options, progress_);
      ASSERT_TRUE(wanted) << wanted.error().message;
      for (const BuiltTerrain* const own : {&made, &opened}) {
        const auto got = extract_terrain(own->terrain(), options, progress_);
        ASSERT_TRUE(got) << got.error().message;
        EXPECT_EQ(got->surface.positions, wanted->surface.positions);
        EXPECT_EQ(got->surface.triangles, wanted->surface.triangles);
        EXPECT_EQ(got->report.achieved_error, wanted->report.achieved_error);
        EXPECT_EQ(got->report.max_error, wanted->report.max_error);
        EXPECT_EQ(got->report.is_within_error, wanted->report.is_within_error);
        EXPECT_EQ(got->report.n_samples, wanted->report.n_samples);
      }
    }
  }
  void expect_passed(const Result<VerifyReport>& report) {
    ASSERT_TRUE(report) << report.error().message;
    for (const VerifyReport::Check& check : report->checks)
      EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  }

  Progress progress_;
  const std::string path_ =
      testing::TempDir() + "lode_pyramid_terrain_" + std::to_string(::getpid()) + ".lode";
};

HeightGrid hills_with_islands() {
  HeightGrid grid = float_grid(61, 47, [](int x, int y) { return rough_hills(x, y); });
  for (std::int32_t y = 20; y < 25; ++y)
    for (std::int32_t x = 0; x < 61; ++x)
      if (x < 20 || x > 24) delaunay::test::set_missing(grid, x, y);
  for (std::int32_t x = 40; x < 44; ++x) delaunay::test::set_missing(grid, x, 9);
  return grid;
}

TEST_P(pyramid_terrain, has_the_pyramids_meshes_at_its_levels) {
  expect_meshes_of_the_pyramid(hills_with_islands(), kTolerances);
  for (const PointCase& c : point_cases()) {
    SCOPED_TRACE(c.name);
    expect_meshes_of_the_pyramid(c.terrain, {20, 5, 0.5});
  }
}

TEST_P(pyramid_terrain, is_true_at_every_level) {
  const HeightGrid grid = hills_with_islands();
  const BuiltTerrain raster = reopened(build(grid, GetParam()));
  expect_passed(raster.verify_alone({2}, progress_));
  expect_passed(raster.verify(grid, {2}, progress_));
  for (const PointCase& c : point_cases()) {
    SCOPED_TRACE(c.name);
    const BuiltTerrain opened = reopened(build(c.terrain, GetParam(), {20, 5, 0.5}));
    expect_passed(opened.verify_alone({2}, progress_));
    expect_passed(opened.verify(c.terrain, {2}, progress_));
  }
  HeightGrid other = grid;
  std::get<HeightGrid::Samples<float>>(
      other.heights)[static_cast<std::size_t>(30 * other.stride)] += 1;
  EXPECT_FALSE(raster.verify(other, {2}, progress_)->passed());
}

TEST_P(pyramid_terrain, takes_the_coarsest_level_within_a_tolerance_or_a_number_of_triangles) {
  const BuiltTerrain opened = reopened(build(hills_with_islands(), GetParam()));
  const auto info = opened.describe(progress_);
  ASSERT_TRUE(info);
  ASSERT_EQ(info->levels.size(), 4U);
  const auto n_triangles = [&](const TerrainOptions& options) {
    const auto made = extract_terrain(opened.terrain(), options, progress_);
    EXPECT_TRUE(made) << made.error().message;
    return made->report.triangles;
  };
  EXPECT_EQ(n_triangles({.max_error = 1000}), info->levels[0].triangles);
  EXPECT_EQ(n_triangles({.max_error = 39.9}), info->levels[1].triangles);
  EXPECT_EQ(n_triangles({.max_error = 2.9}), info->levels[3].triangles);
  EXPECT_EQ(n_triangles({.max_error = info->max_error}), info->levels[3].triangles);
  EXPECT_EQ(n_triangles({.max_cells = info->levels[2].triangles}), info->levels[2].triangles);
  EXPECT_EQ(n_triangles({.max_cells = info->levels[2].triangles - 1}), info->levels[1].triangles);
  EXPECT_EQ(n_triangles({.max_error = 12, .max_cells = 1'000'000}), info->levels[1].triangles);
  const auto few = extract_terrain(opened.terrain(), {.max_cells = 3}, progress_);
  ASSERT_TRUE(few);
  EXPECT_FALSE(few->report.budget_met);
  EXPECT_EQ(few->report.triangles, info->levels[0].triangles);
  const auto finer = extract_terrain(opened.terrain(), {.max_error = 0.01}, progress_);
  ASSERT_FALSE(finer);
  EXPECT_NE(finer.error().message.find("built for"), std::string::npos);
}

TEST_P(pyramid_terrain, refuses_tolerances_that_vary_and_says_why) {
  const BuiltTerrain opened = reopened(build(hills_with_islands(), GetParam()));
  const std::vector<PlaceBox> boxes{{{{5, 5}}, {{12, 20}}}};
  const auto ask = [&](const TerrainFocus& focus) {
    return extract_terrain(opened.terrain(), {.max_error = 3, .focus = focus}, progress_);
  };
  // What one level keeps is answered with it.
  const auto whole = extract_terrain(opened.terrain(), {.max_error = 3}, progress_);
  for (const TerrainFocus& focus :
       {TerrainFocus{.boxes = boxes}, TerrainFocus{.boxes = boxes, .max_error_outside = 3},
        TerrainFocus{.boxes = {}, .point = Vec<double, 2>{{5, 5}}, .growth = 0}}) {
    const auto got = ask(focus);
    ASSERT_TRUE(got) << got.error().message;
    EXPECT_EQ(got->surface.triangles, whole->surface.triangles);
  }
  TerrainView view;
  view.view.camera.eye = {{0, -100, 50}};
  for (const auto& [focus, what] :
       {std::pair(TerrainFocus{.boxes = boxes, .max_error_outside = 12}, "outside of the focus"),
        {TerrainFocus{.boxes = {}, .point = Vec<double, 2>{{5, 5}}, .growth = 0.1}, "grows"},
        {TerrainFocus{.boxes = {}, .view = view}, "a view"}}) {
    const auto got = ask(focus);
    ASSERT_FALSE(got);
    for (const std::string& word : {std::string(what), std::string(name_of(GetParam())),
                                    std::string("delaunay_pyramid"), std::string("do not meet")})
      EXPECT_NE(got.error().message.find(word), std::string::npos) << got.error().message;
  }
}

TEST_P(pyramid_terrain, says_what_its_parts_take) {
  const BuiltTerrain made = build(hills_with_islands(), GetParam());
  const BuiltTerrain opened = reopened(made);
  const auto info = opened.describe(progress_);
  const auto said = made.describe(progress_);
  ASSERT_TRUE(info && said);
  EXPECT_EQ(info->n_links > 0, has_links(GetParam()));
  EXPECT_EQ(info->n_links, said->n_links);
  EXPECT_EQ(info->n_triangles, said->n_triangles);
  EXPECT_EQ(info->memory_bytes, said->memory_bytes);
  std::uint64_t memory = 0;
  std::uint64_t in_file = 0;
  for (const BuiltTerrainInfo::Part& part : info->parts) {
    memory += part.memory_bytes;
    EXPECT_GT(part.file_bytes, 0U) << part.name;
    in_file += part.file_bytes;
  }
  EXPECT_EQ(memory, info->memory_bytes);
  EXPECT_LT(in_file, std::filesystem::file_size(path_));
  for (std::size_t i = 0; i < info->levels.size(); ++i) {
    EXPECT_EQ(info->levels[i].triangles, said->levels[i].triangles);
    EXPECT_EQ(info->levels[i].smallest_angle, said->levels[i].smallest_angle);
  }
}

TEST_P(pyramid_terrain, limits_the_memory_of_links) {
  const auto made = BuiltTerrain::build(
      hills_with_islands(), {.model = GetParam(), .levels = kTolerances, .memory_limit = 2000},
      progress_);
  EXPECT_EQ(made.has_value(), !has_links(GetParam()));
  if (!made) EXPECT_NE(made.error().message.find("2000 bytes"), std::string::npos);
}

/// With the least limit of links that a build succeeds within: found by halves.
TEST_P(pyramid_terrain, has_links_within_their_limit_and_none_with_a_byte_less) {
  if (!has_links(GetParam())) return;
  const HeightGrid grid = hills_with_islands();
  const auto build_within = [&](std::uint64_t n_bytes) {
    return BuiltTerrain::build(
        grid, {.model = GetParam(), .levels = kTolerances, .memory_limit = n_bytes}, progress_);
  };
  std::uint64_t least = 1 << 24;
  ASSERT_TRUE(build_within(least));
  for (std::uint64_t too_few = 0; too_few + 1 < least;) {
    const std::uint64_t middle = too_few + (least - too_few) / 2;
    (build_within(middle) ? least : too_few) = middle;
  }
  EXPECT_FALSE(build_within(least - 1));
  const auto made = build_within(least);
  ASSERT_TRUE(made);
  const auto info = made->describe(progress_);
  ASSERT_TRUE(info);
  const auto links = std::ranges::find(info->parts, "links", &BuiltTerrainInfo::Part::name);
  ASSERT_NE(links, info->parts.end());
  EXPECT_LE(links->memory_bytes, least);
  // An array that grows is there twice: once as it was, and once with half as much room again.
  EXPECT_LE(least, links->memory_bytes * 5 / 2 + 100);
  EXPECT_EQ(made->describe_source().n_links, build(grid, GetParam()).describe_source().n_links);
}

/// The directory of the shared real data: LODE_DATA, else ../shared/data beside the sources.
std::filesystem::path shared_data() {
  if (const char* directory = std::getenv("LODE_DATA")) return directory;
  return (std::filesystem::path(LODE_TEST_FILES_DIR) / "../../../shared/data").lexically_normal();
}

TEST_P(pyramid_terrain, has_the_pyramids_meshes_of_st_helens) {
  const std::string path = (shared_data() / "terrain" / "st_helens_327x468_int16.tif").string();
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set LODE_DATA";
  const auto raster = read_heights(path, {}, progress_);
  ASSERT_TRUE(raster) << raster.error().message;
  expect_meshes_of_the_pyramid(raster->grid, {50, 20, 10, 5, 2});
  const auto opened = BuiltTerrain::open(path_, progress_);
  expect_passed(opened->verify_alone({2}, progress_));
  // Finer levels have several blocks of each kind, of which links lead to some.
  std::vector<Place> places;
  for (int i = 0; i < 300; ++i)
    places.push_back(opened->frame().world(i * 37 % 327 + i % 3 * 0.25, i * 53 % 468 * 0.99));
  for (const double tolerance : {20.0, 2.0}) {
    std::array<std::vector<TerrainHeight>, 2> heights;
    for (const TinUse use : {TinUse::all, TinUse::places}) {
      const auto tin =
          TerrainTin::select(opened->terrain(), {.max_error = tolerance}, {}, progress_, use);
      ASSERT_TRUE(tin) << tin.error().message;
      ASSERT_TRUE(tin->heights(places, heights[use == TinUse::all ? 0 : 1], {2}, progress_));
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      EXPECT_EQ(heights[0][i].where, heights[1][i].where);
      EXPECT_EQ(heights[0][i].height, heights[1][i].height);
      EXPECT_EQ(heights[0][i].bound, heights[1][i].bound);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(models, pyramid_terrain,
                         testing::Values(TerrainModel::complete_pyramid,
                                         TerrainModel::triangle_lists,
                                         TerrainModel::linked_triangle_lists),
                         [](const auto& model) { return std::string(name_of(model.param)); });

}  // namespace
}  // namespace lode::test
