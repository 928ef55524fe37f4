// Contours, sight and heights of real terrain, and what holds between them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "lode/api/files.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

std::filesystem::path answers_data() {
  if (const char* directory = std::getenv("LODE_DATA")) return directory;
  return (std::filesystem::path(LODE_TEST_FILES_DIR) / "../../../shared/data").lexically_normal();
}

struct RealCase {
  const char* name;
  double max_error;
  HeightEncoding encoding = HeightEncoding::none;
};

class terrain_answers : public testing::TestWithParam<RealCase> {
 protected:
  void SetUp() override {
    const std::string path = (answers_data() / "terrain" / GetParam().name).string();
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set LODE_DATA";
    Progress progress;
    auto read = read_heights(path, {.encoding = GetParam().encoding}, progress);
    ASSERT_TRUE(read) << read.error().message;
    raster_ = std::make_unique<HeightRaster>(std::move(read).value());
    auto metric = read_metric(raster_->grid.crs);
    ASSERT_TRUE(metric) << metric.error().message;
    metric_ = std::move(metric).value();
    auto tin =
        TerrainTin::select(raster_->grid, {.max_error = GetParam().max_error}, metric_, progress);
    ASSERT_TRUE(tin) << tin.error().message;
    tin_ = std::make_unique<TerrainTin>(std::move(tin).value());
  }

  [[nodiscard]] Place random_place(oracles::Random& random) const {
    return raster_->grid.world(random.uniform(0, raster_->grid.n_columns - 1),
                               random.uniform(0, raster_->grid.n_rows - 1));
  }

  std::unique_ptr<HeightRaster> raster_;
  HorizontalMetric metric_;
  std::unique_ptr<TerrainTin> tin_;
};

TEST_P(terrain_answers, have_heights_within_their_bounds_at_every_sample) {
  const HeightGrid& grid = raster_->grid;
  std::vector<Place> places;
  std::vector<double> samples;
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x)
      if (grid.has_height(x, y)) {
        places.push_back(grid.world(x, y));
        samples.push_back(grid.height(x, y));
      }
  std::vector<TerrainHeight> heights;
  Progress progress;
  const auto report = tin_->heights(places, heights, {2}, progress);
  ASSERT_TRUE(report);
  EXPECT_EQ(places.size() - report->n_in_gaps - report->n_outside, tin_->report().n_samples);
  std::size_t n_beyond = 0;
  for (std::size_t i = 0; i < places.size(); ++i)
    n_beyond +=
        static_cast<std::size_t>(heights[i].where == TerrainHeight::Where::inside &&
                                 !(std::abs(heights[i].height - samples[i]) <= heights[i].bound));
  EXPECT_EQ(n_beyond, 0U);
}

TEST_P(terrain_answers, have_profiles_that_agree_with_heights) {
  oracles::Random random(17);
  Progress progress;
  for (int i = 0; i < 20; ++i) {
    const auto profile = tin_->profile(random_place(random), random_place(random), progress);
    ASSERT_TRUE(profile);
    std::vector<Place> places;
    for (const auto& point : profile->points) places.push_back(point.at);
    std::vector<TerrainHeight> heights;
    ASSERT_TRUE(tin_->heights(places, heights, {1}, progress));
    const HeightRange range = tin_->height_range();
    for (std::size_t k = 0; k < places.size(); ++k)
      // Places of rows are rounded: 2^-45 of a raster's side times the steepest slope.
      if (heights[k].where == TerrainHeight::Where::inside)
        EXPECT_NEAR(heights[k].height, profile->points[k].height,
                    1e-8 * (range.upper - range.lower));
  }
}

TEST_P(terrain_answers, have_contours_at_their_heights) {
  Progress progress;
  const HeightRange range = tin_->height_range();
  std::vector<double> levels;
  for (int i = 1; i < 8; ++i)
    levels.push_back(std::round(range.lower + (range.upper - range.lower) * i / 8));
  const auto contours = tin_->contours(levels, progress);
  ASSERT_TRUE(contours);
  EXPECT_GT(contours->lines.size(), 5U);
  std::vector<Place> places;
  std::vector<double> wanted;
  for (const auto& line : contours->lines) {
    if (line.is_ring) EXPECT_EQ(line.points.front(), line.points.back());
    for (const Place& at : line.points) {
      places.push_back(at);
      wanted.push_back(line.height);
    }
  }
  std::vector<TerrainHeight> heights;
  ASSERT_TRUE(tin_->heights(places, heights, {2}, progress));
  std::size_t n_off = 0;
  for (std::size_t i = 0; i < places.size(); ++i)
    n_off += static_cast<std::size_t>(heights[i].where == TerrainHeight::Where::inside &&
                                      std::abs(heights[i].height - wanted[i]) >
                                          1e-8 * (range.upper - range.lower));
  EXPECT_EQ(n_off, 0U);
}

TEST_P(terrain_answers, see_the_same_at_every_tolerance_that_decides) {
  oracles::Random random(29);
  Progress progress;
  int n_decided = 0;
  const TerrainOptions exact{.max_error = 0};
  const auto full = TerrainTin::select(raster_->grid, exact, metric_, progress);
  ASSERT_TRUE(full);
  for (int i = 0; i < 60; ++i) {
    const Place from = random_place(random);
    // As far as a tenth of the raster.
    const Place to = from * 0.9 + random_place(random) * 0.1;
    const TerrainSightOptions options{
        .from = from, .to = to, .observer_height = 10, .target_height = 10};
    const auto coarse = tin_->sight(options, progress);
    if (!coarse) continue;  // In a gap.
    const auto fine = full->sight(options, progress);
    ASSERT_TRUE(fine);
    EXPECT_TRUE(fine->verdict != SightVerdict::undecided || fine->has_gap);
    n_decided += static_cast<int>(coarse->verdict != SightVerdict::undecided);
    if (coarse->verdict == SightVerdict::blocked) EXPECT_EQ(fine->verdict, SightVerdict::blocked);
  }
  EXPECT_GT(n_decided, 0);
}

INSTANTIATE_TEST_SUITE_P(terrain, terrain_answers,
                         testing::ValuesIn(oracles::trials<std::vector<RealCase>>(
                             {{"st_helens_327x468_int16.tif", 20},
                              {"gabilan_lidar_921x859_float32.tif", 2},
                              {"trinidad_co_2401x1201_float32.tif", 100},
                              {"fuji_terrain_rgb_512x512.png", 10, HeightEncoding::terrain_rgb}},
                             {{"st_helens_327x468_int16.tif", 20},
                              {"fuji_terrain_rgb_512x512.png", 10, HeightEncoding::terrain_rgb}})),
                         [](const auto& real) {
                           std::string name = real.param.name;
                           std::replace_if(
                               name.begin(), name.end(),
                               [](char c) { return std::isalnum(c) == 0; }, '_');
                           return name;
                         });

}  // namespace
}  // namespace lode
