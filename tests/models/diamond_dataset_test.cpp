// The whole path in memory and through a file, on volumes that are hard for it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "lode/api/dataset.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

Volume random_volume(const Index3& dims, std::uint32_t seed, double hole_share) {
  std::mt19937 random(seed);
  RegularGrid grid;
  grid.dims = dims;
  std::vector<float> values(static_cast<std::size_t>(grid.n_samples()));
  for (float& v : values) {
    v = static_cast<float>(random() % 1000) / 10.0F;
    if (static_cast<double>(random() % 10000) < hole_share * 10000)
      v = std::numeric_limits<float>::quiet_NaN();
  }
  return make_volume<float>(grid, values);
}

Volume ball_volume(const Index3& dims, double radius) {
  RegularGrid grid;
  grid.dims = dims;
  std::vector<std::uint8_t> values;
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (std::int32_t x = 0; x < dims[0]; ++x) {
        const double dx = x - 0.5 * (dims[0] - 1);
        const double dy = y - 0.5 * (dims[1] - 1);
        const double dz = z - 0.5 * (dims[2] - 1);
        const double r = std::sqrt(dx * dx + dy * dy + dz * dz) / radius;
        values.push_back(static_cast<std::uint8_t>(std::clamp(255 - 127.5 * r, 0.0, 255.0)));
      }
  return make_volume<std::uint8_t>(grid, values);
}

Dataset build(const Volume& volume, int threads = 2) {
  Progress progress;
  const auto source = make_memory_source(volume);
  auto dataset = Dataset::build(*source, {.threads = {threads}}, progress);
  EXPECT_TRUE(dataset) << (dataset ? "" : dataset.error().message);
  return std::move(dataset).value();
}

void expect_passed(const Result<VerifyReport>& report) {
  ASSERT_TRUE(report) << report.error().message;
  for (const VerifyReport::Check& check : report->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

Surface expect_true_surface(const Dataset& dataset, double isovalue, double max_error) {
  Progress progress;
  Surface surface;
  const ExtractOptions options{.isovalues = {isovalue}, .max_error = max_error, .threads = {2}};
  const auto report = dataset.extract(options, surface, progress);
  EXPECT_TRUE(report) << (report ? "" : report.error().message);
  if (report) {
    EXPECT_LE(report->achieved_error, max_error);
  }
  expect_passed(dataset.verify_surface(surface, options, progress));
  return surface;
}

TEST(long_contour, stays_whole_where_a_seam_runs_next_to_the_border) {
  // One sample beyond a brick's border, and so long that float32 leaves a wide margin.
  RegularGrid grid;
  grid.dims = {{8194, 258, 1}};
  std::vector<float> values;
  for (int y = 0; y < 258; ++y)
    for (int x = 0; x < 8194; ++x)
      values.push_back(static_cast<float>(y + 20 * std::abs(std::remainder(x / 128.0, 2.0))));
  const Dataset dataset = build(make_volume<float>(grid, values));
  const Surface contour = expect_true_surface(dataset, 60.3, 1);
  float reach = 0;
  for (const Vec3f& p : contour.positions) reach = std::max(reach, p[0]);
  EXPECT_EQ(reach, 8193);
}

class awkward_shapes : public ::testing::TestWithParam<Index3> {};

TEST_P(awkward_shapes, have_true_errors_and_clean_surfaces_at_any_tolerance) {
  const Volume volume = random_volume(GetParam(), 7, 0);
  const Dataset dataset = build(volume);
  Progress progress;
  const auto source = make_memory_source(volume);
  expect_passed(dataset.verify_against(*source, {2}, progress));
  for (const double max_error : {0.0, 10.0, 60.0, 1000.0})
    expect_true_surface(dataset, 50.0, max_error);
}

INSTANTIATE_TEST_SUITE_P(dims, awkward_shapes,
                         ::testing::Values(Index3{{2, 2, 2}}, Index3{{3, 3, 3}},
                                           Index3{{2, 300, 2}}, Index3{{1, 64, 64}},
                                           Index3{{37, 35, 6}}, Index3{{33, 18, 34}},
                                           Index3{{1, 1, 9}}, Index3{{150, 1, 133}}));

TEST(dataset, keeps_true_errors_and_clean_surfaces_round_scattered_holes) {
  const Volume volume = random_volume({{36, 20, 17}}, 3, 0.05);
  const Dataset dataset = build(volume);
  EXPECT_GT(dataset.describe().n_holes, 0U);
  for (const double max_error : {0.0, 30.0}) expect_true_surface(dataset, 50.0, max_error);
}

TEST(dataset, extracts_a_closed_ball_with_fewer_triangles_at_a_tolerance) {
  const Dataset dataset = build(ball_volume({{65, 65, 65}}, 20));
  const Surface full = expect_true_surface(dataset, 127.5, 0);
  const Surface coarse = expect_true_surface(dataset, 127.5, 6);
  EXPECT_GT(full.triangles.size(), 10000U);
  EXPECT_LT(coarse.triangles.size() * 4, full.triangles.size());
}

TEST(dataset, handles_isovalues_equal_to_samples) {
  const Dataset dataset = build(ball_volume({{34, 33, 35}}, 9));
  for (const double isovalue : {1.0, 128.0, 200.0}) expect_true_surface(dataset, isovalue, 0);
}

TEST(dataset, drops_small_pieces_and_turns_the_surface_and_still_holds) {
  const Dataset dataset = build(random_volume({{20, 19, 18}}, 5, 0));
  Progress progress;
  Surface all;
  const auto whole = dataset.extract({.isovalues = {20}, .threads = {2}}, all, progress);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->components_dropped, 0U);
  const ExtractOptions options{.isovalues = {20},
                               .min_component = 30,
                               .orientation = Orientation::from_higher_values,
                               .threads = {2}};
  Surface surface;
  const auto report = dataset.extract(options, surface, progress);
  ASSERT_TRUE(report);
  EXPECT_GT(report->components_dropped, 0U);
  EXPECT_EQ(report->triangles + report->triangles_dropped, whole->triangles);
  expect_passed(dataset.verify_surface(surface, options, progress));
}

TEST(dataset, gives_an_empty_surface_where_the_isovalue_meets_nothing) {
  const Dataset dataset = build(ball_volume({{20, 20, 20}}, 6));
  EXPECT_TRUE(expect_true_surface(dataset, 1e6, 0).is_empty());
  EXPECT_TRUE(expect_true_surface(dataset, -5, 0).is_empty());
}

TEST(dataset, gives_the_same_surface_for_any_number_of_threads) {
  const Volume volume =
      random_volume(oracles::trials<Index3>({{70, 40, 38}}, {{70, 40, 9}}), 11, 0.001);
  Progress progress;
  Surface one;
  Surface three;
  const Dataset a = build(volume, 1);
  const Dataset b = build(volume, 3);
  ExtractOptions options{.isovalues = {40.0}, .max_error = 20.0, .threads = {1}};
  ASSERT_TRUE(a.extract(options, one, progress));
  options.threads = {3};
  ASSERT_TRUE(b.extract(options, three, progress));
  EXPECT_EQ(one.positions, three.positions);
  EXPECT_EQ(one.triangles, three.triangles);
  EXPECT_EQ(one.normals, three.normals);
}

TEST(dataset, comes_back_from_a_file_as_it_was) {
  const auto directory =
      std::filesystem::temp_directory_path() / ("lode_dataset_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(directory);
  const std::string path = (directory / "volume.lode").string();
  const Volume volume = random_volume({{70, 20, 38}}, 5, 0.001);
  Progress progress;
  const Dataset dataset = build(volume);
  ASSERT_TRUE(dataset.save(path, {2}, progress));
  expect_passed(verify_file(path, {2}, progress));
  auto opened = Dataset::open(path, {2});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->describe().volume, dataset.describe().volume);
  const ExtractOptions options{.isovalues = {40.0}, .max_error = 15.0, .threads = {2}};
  Surface before;
  Surface after;
  ASSERT_TRUE(dataset.extract(options, before, progress));
  ASSERT_TRUE(opened->extract(options, after, progress));
  EXPECT_EQ(before.positions, after.positions);
  EXPECT_EQ(before.triangles, after.triangles);
  std::filesystem::remove_all(directory);
}

TEST(dataset, refuses_nonsense_options) {
  const Dataset dataset = build(ball_volume({{8, 8, 8}}, 2));
  Progress progress;
  Surface surface;
  EXPECT_FALSE(dataset.extract({.isovalues = {}}, surface, progress));
  EXPECT_FALSE(dataset.extract({.isovalues = {std::nan("")}}, surface, progress));
  EXPECT_FALSE(dataset.extract({.isovalues = {1}, .max_error = -1.0}, surface, progress));
}

}  // namespace
}  // namespace lode
