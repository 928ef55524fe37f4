#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>

#include "lode/api/files.h"
#include "lode/api/terrain.h"
#include "lode/mappers/tin_gaps.h"
#include "lode/mappers/tin_quality.h"
#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

/// The directory of the shared real data: LODE_DATA, else ../shared/data beside the sources.
std::filesystem::path data_directory() {
  if (const char* directory = std::getenv("LODE_DATA")) return directory;
  return (std::filesystem::path(LODE_TEST_FILES_DIR) / "../../../shared/data").lexically_normal();
}

struct RealTerrain {
  const char* name;
  std::vector<double> tolerances;
  HeightEncoding encoding = HeightEncoding::none;
};

class real_terrain : public testing::TestWithParam<RealTerrain> {
 protected:
  void SetUp() override {
    const RealTerrain& real = GetParam();
    const std::string path = (data_directory() / "terrain" / real.name).string();
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set LODE_DATA";
    auto read = read_heights(path, {.encoding = real.encoding}, progress_);
    ASSERT_TRUE(read) << read.error().message;
    raster_.emplace(*std::move(read));
  }

  Progress progress_;
  std::optional<HeightRaster> raster_;
};

TEST_P(real_terrain, is_delaunay_and_within_every_tolerance_in_all_orders) {
  const RealTerrain& real = GetParam();
  for (const double tolerance : real.tolerances)
    for (const InsertionOrder order :
         {InsertionOrder::levels, InsertionOrder::strict, InsertionOrder::tiles}) {
      const auto made =
          extract_terrain(raster_->grid, {.max_error = tolerance, .order = order}, progress_);
      ASSERT_TRUE(made) << made.error().message;
      EXPECT_LE(made->report.achieved_error, tolerance);
      const auto shape = order == InsertionOrder::tiles ? TinShape::tiles : TinShape::delaunay;
      const auto checked =
          verify_terrain(raster_->grid, made->surface,
                         {.max_error = made->report.achieved_error, .shape = shape}, progress_);
      ASSERT_TRUE(checked);
      for (const VerifyReport::Check& check : checked->checks)
        EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
      EXPECT_EQ(checked->checks.size(), 6U);
    }
}

TEST_P(real_terrain, has_a_pyramid_that_is_true_and_that_its_file_keeps) {
  const RealTerrain& real = GetParam();
  const auto built = BuiltTerrain::build(raster_->grid, {.levels = real.tolerances}, progress_);
  ASSERT_TRUE(built) << built.error().message;
  const auto checked = built->verify(raster_->grid, {}, progress_);
  ASSERT_TRUE(checked) << checked.error().message;
  for (const VerifyReport::Check& check : checked->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  const std::string file = testing::TempDir() + "lode_" + real.name + ".lode";
  ASSERT_TRUE(built->save(file, progress_));
  const auto opened = BuiltTerrain::open(file, progress_);
  std::filesystem::remove(file);
  ASSERT_TRUE(opened) << opened.error().message;
  const BuiltTerrainInfo before = *built->describe(progress_);
  const BuiltTerrainInfo after = *opened->describe(progress_);
  EXPECT_EQ(after.n_triangles, before.n_triangles);
  ASSERT_EQ(after.levels.size(), real.tolerances.size());
  for (std::size_t i = 0; i < after.levels.size(); ++i) {
    EXPECT_EQ(after.levels[i].triangles, before.levels[i].triangles);
    EXPECT_EQ(after.levels[i].median_angle, before.levels[i].median_angle);
  }
}

void expect_levels_kept(const triangle_hierarchy::Hierarchy& hierarchy, const HeightGrid& grid) {
  const HeightRange range = height_range(grid);
  const double rounding = 0x1p-47 * std::max(std::abs(range.lower), std::abs(range.upper));
  for (int level = 0; level < hierarchy.n_levels(); ++level) {
    const auto tin = tin_of_level(hierarchy, level, delaunay::TinLinks::left_out);
    const TinQuality quality = measure_quality(tin, hierarchy.scale(), grid, {2});
    EXPECT_LE(quality.worst_error,
              hierarchy.tolerances[static_cast<std::size_t>(level)] + rounding);
    EXPECT_EQ(measure_gaps(tin).n_hanging, 0U);
  }
}

TEST_P(real_terrain, has_hierarchies_that_keep_the_tolerances_of_all_levels) {
  std::vector<double> levels = GetParam().tolerances;
  if (levels.back() == 0) levels.pop_back();
  const auto adaptive = adaptive_triangulation::build(raster_->grid, levels, {2}, progress_);
  ASSERT_TRUE(adaptive) << adaptive.error().message;
  expect_levels_kept(adaptive->hierarchy, raster_->grid);
  const auto made = hierarchical_delaunay::build(raster_->grid, levels, {2}, progress_);
  ASSERT_TRUE(made) << made.error().message;
  expect_levels_kept(made->hierarchy, raster_->grid);
  EXPECT_EQ(made->n_edges_left, 0U);
}

INSTANTIATE_TEST_SUITE_P(
    terrain, real_terrain,
    testing::ValuesIn(oracles::trials<std::vector<RealTerrain>>(
        {{"st_helens_327x468_int16.tif", {200, 30, 3, 0}},
         {"big_tujunga_1197x643_int16.tif", {100, 20}},
         {"gabilan_lidar_921x859_float32.tif", {20, 1}},
         {"trinidad_co_2401x1201_float32.tif", {200}},
         {"etopo5_4320x2161_int16.tif", {1000}},
         {"N00E010_1201x1201_int16be.hgt.gz", {50}},
         {"fuji_terrain_rgb_512x512.png", {30, 10}, HeightEncoding::terrain_rgb}},
        // Of each format and type the smallest.
        {{"st_helens_327x468_int16.tif", {200, 30, 3, 0}},
         {"gabilan_lidar_921x859_float32.tif", {20}},
         {"N00E010_1201x1201_int16be.hgt.gz", {200}},
         {"fuji_terrain_rgb_512x512.png", {30}, HeightEncoding::terrain_rgb}})),
    [](const auto& real) {
      std::string name = real.param.name;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return std::isalnum(c) == 0; }, '_');
      return name;
    });

}  // namespace
}  // namespace lode
