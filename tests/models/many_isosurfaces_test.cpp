// Several isovalues extracted in one traversal must give what one after the other gives, to the
// bit.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "lode/api/dataset.h"
#include "tests/models/built_dataset.h"
#include "tests/models/rough_volume.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/synthetic_volumes.h"
#include "tests/oracles/trials.h"
#include "tests/store/test_file.h"

namespace lode {
namespace {

struct Extracted {
  Surface surface;
  ExtractReport report;
};

Extracted extracted(const Dataset& dataset, const ExtractOptions& options) {
  Progress progress;
  Extracted result;
  auto report = dataset.extract(options, result.surface, progress);
  if (!report) throw std::runtime_error(report.error().message);
  result.report = *report;
  return result;
}

/// Surfaces of one isovalue each, one behind the other.
Extracted one_by_one(const Dataset& dataset, ExtractOptions options) {
  Extracted all;
  const std::vector<double> isovalues = options.isovalues;
  for (const double isovalue : isovalues) {
    options.isovalues = {isovalue};
    const Extracted one = extracted(dataset, options);
    const auto n = static_cast<std::uint32_t>(all.surface.positions.size());
    const auto append = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(all.surface.positions, one.surface.positions);
    append(all.surface.normals, one.surface.normals);
    EXPECT_TRUE(one.surface.isovalues.empty());
    if (isovalues.size() > 1) all.surface.isovalues.resize(all.surface.positions.size(), isovalue);
    for (auto cell : one.surface.triangles)
      all.surface.triangles.push_back({cell[0] + n, cell[1] + n, cell[2] + n});
    for (auto cell : one.surface.lines) all.surface.lines.push_back({cell[0] + n, cell[1] + n});
    all.report.achieved_error = std::max(all.report.achieved_error, one.report.achieved_error);
    all.report.coordinate_slack =
        std::max(all.report.coordinate_slack, one.report.coordinate_slack);
    all.report.nodes_visited += one.report.nodes_visited;
    append(all.report.unmet, one.report.unmet);
  }
  return all;
}

void expect_same(const Extracted& together, const Extracted& apart) {
  EXPECT_EQ(together.surface.positions, apart.surface.positions);
  EXPECT_EQ(together.surface.normals, apart.surface.normals);
  EXPECT_EQ(together.surface.isovalues, apart.surface.isovalues);
  EXPECT_EQ(together.surface.triangles, apart.surface.triangles);
  EXPECT_EQ(together.surface.lines, apart.surface.lines);
  EXPECT_EQ(together.report.achieved_error, apart.report.achieved_error);
  EXPECT_EQ(together.report.coordinate_slack, apart.report.coordinate_slack);
  EXPECT_EQ(together.report.unmet, apart.report.unmet);
}

/// In no order, at both ends of the range, on samples, and beyond.
std::vector<double> some_isovalues(const Dataset& dataset) {
  const DatasetInfo info = dataset.describe();
  const double width = info.range_max - info.range_min;
  return {info.range_min + 0.5 * width,
          info.range_max,
          info.range_min + 0.51 * width,
          info.range_min - 1,
          info.range_min,
          info.range_min + 0.2 * width,
          info.range_max + 1,
          info.range_min + 0.9 * width};
}

/// With a tolerance a file's are extracted chunk by chunk.
void expect_same_surfaces_of(const Dataset& dataset);

void expect_same_surfaces(const Volume& volume) {
  const Dataset dataset = test::built_dataset(volume);
  expect_same_surfaces_of(dataset);
  const store::TestPath path("many.lode");
  Progress progress;
  ASSERT_TRUE(dataset.save(path.str(), {2}, progress));
  const auto stored = Dataset::open(path.str(), {2});
  ASSERT_TRUE(stored);
  SCOPED_TRACE("from a file");
  expect_same_surfaces_of(*stored);
}

void expect_same_surfaces_of(const Dataset& dataset) {
  const DatasetInfo info = dataset.describe();
  for (const double share : {0.0, 0.01, 0.1, 2.0}) {
    SCOPED_TRACE(share);
    ExtractOptions options{.isovalues = some_isovalues(dataset),
                           .max_error = share * (info.range_max - info.range_min),
                           .threads = {2}};
    const Extracted apart = one_by_one(dataset, options);
    if (share == 0) EXPECT_FALSE(apart.surface.is_empty());
    for (const int threads : {1, 3}) {
      options.threads = {threads};
      expect_same(extracted(dataset, options), apart);
    }
  }
}

class many_isosurfaces_shapes : public testing::TestWithParam<Index3> {};

TEST_P(many_isosurfaces_shapes, are_those_of_one_after_the_other) {
  expect_same_surfaces(test::rough_volume<std::uint8_t>(GetParam(), 0));
  expect_same_surfaces(test::rough_volume<float>(GetParam(), 0));
}

TEST_P(many_isosurfaces_shapes, are_those_of_one_after_the_other_between_holes) {
  expect_same_surfaces(test::rough_volume<float>(GetParam(), 0.01));
}

INSTANTIATE_TEST_SUITE_P(dims, many_isosurfaces_shapes,
                         testing::Values(Index3{{2, 3, 2}}, Index3{{34, 33, 5}},
                                         oracles::trials<Index3>({{41, 67, 36}}, {{34, 41, 12}}),
                                         Index3{{97, 1, 45}}, Index3{{300, 129, 1}}));

TEST(many_isosurfaces, are_those_of_one_after_the_other_where_coarse_leaves_suffice) {
  expect_same_surfaces(
      oracles::linear_ramp({{130, 66, 97}}, ScalarType::float32, {{1, 0.5, 0.25}}));
  expect_same_surfaces(oracles::sample(oracles::Field::gaussians40, 65));
}

TEST(many_isosurfaces, come_once_each) {
  const Dataset dataset = test::built_dataset(test::rough_volume<float>({{41, 37, 36}}, 0));
  Progress progress;
  Surface surface;
  const auto twice = dataset.extract({.isovalues = {100, 120, 100}}, surface, progress);
  ASSERT_FALSE(twice);
  EXPECT_NE(twice.error().message.find("got 100 twice"), std::string::npos);
}

TEST(many_isosurfaces, of_a_file_read_each_block_once) {
  const Dataset dataset = test::built_dataset(oracles::sample(oracles::Field::gaussians40, 129));
  const store::TestPath path("many.lode");
  Progress progress;
  ASSERT_TRUE(dataset.save(path.str(), {2}, progress));
  ExtractOptions options{.isovalues = {1}, .max_error = 0.01, .threads = {1}};
  const std::uint64_t n_once =
      extracted(*Dataset::open(path.str(), {1}), options).report.bytes_read;
  for (int i = 1; i < 10; ++i) options.isovalues.push_back(1 + 0.001 * i);
  EXPECT_LT(extracted(*Dataset::open(path.str(), {1}), options).report.bytes_read,
            n_once + n_once / 4);
}

/// Noise has more surface than is guessed, so that in the middle of a pass there is no room left.
TEST(many_isosurfaces, of_a_file_that_do_not_fit_take_more_passes) {
  const Dataset dataset = test::built_dataset(
      oracles::integer_noise(oracles::trials<Index3>({{300, 24, 20}}, {{300, 12, 10}}),
                             {.type = ScalarType::uint8, .seed = 3, .low = 0, .high = 255}));
  const store::TestPath path("many.lode");
  Progress progress;
  ASSERT_TRUE(dataset.save(path.str(), {2}, progress));
  const auto stored = Dataset::open(path.str(), {2});
  ASSERT_TRUE(stored);
  ExtractOptions options{
      .isovalues = {90, 150, 120, 200, 60, 128}, .max_error = 5.0, .threads = {2}};
  const Extracted apart = one_by_one(*stored, options);
  for (const std::uint64_t limit : oracles::trials<std::vector<std::uint64_t>>(
           {10'000'000, 40'000'000, 150'000'000, 1'000'000'000},
           {2'500'000, 10'000'000, 1'000'000'000})) {
    SCOPED_TRACE(limit);
    options.memory_limit = limit;
    const Extracted together = extracted(*stored, options);
    expect_same(together, apart);
    // What is dropped has been begun in vain, once.
    EXPECT_LT(together.report.nodes_visited, apart.report.nodes_visited * 2);
    if (limit == 1'000'000'000)
      EXPECT_LT(together.report.nodes_visited, apart.report.nodes_visited * 5 / 4);
  }
}

/// Which float32 would take for one, or for none.
TEST(many_isosurfaces, may_be_nearer_than_float32_tells_apart) {
  const auto wave = [](const Index3& p) {
    return std::sin(0.7 * p[0] + 0.2 * p[2]) * std::cos(0.5 * p[1]);
  };
  const RegularGrid grid{.dims = {{17, 15, 13}}};
  struct Scale {
    double offset;
    double width;
  };
  for (const Scale& scale :
       {Scale{1e6, 0.01}, Scale{101325, 0.05}, Scale{0, 1e300}, Scale{0, 1e-46}}) {
    SCOPED_TRACE(scale.width);
    const Dataset dataset = test::built_dataset(oracles::volume_of<double>(
        grid, [&](const Index3& p) { return scale.offset + scale.width * wave(p); }));
    const ExtractOptions options{
        .isovalues = {scale.offset + 0.25 * scale.width, scale.offset + 0.5 * scale.width},
        .max_error = 0.0,
        .threads = {2}};
    Surface surface = extracted(dataset, options).surface;
    EXPECT_EQ(surface.isovalues.front(), options.isovalues.front());
    EXPECT_EQ(surface.isovalues.back(), options.isovalues.back());
    Progress progress;
    const auto report = dataset.verify_surface(surface, options, progress);
    ASSERT_TRUE(report);
    for (const auto& check : report->checks)
      EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
    std::ranges::reverse(surface.isovalues);
    EXPECT_FALSE(dataset.verify_surface(surface, options, progress)->passed());
  }
}

/// As glTF does.
TEST(many_isosurfaces, that_a_file_has_rounded_are_verified_all_the_same) {
  const Dataset dataset = test::built_dataset(test::rough_volume<float>({{23, 19, 21}}, 0));
  const ExtractOptions options{.isovalues = {90.3, 110.7}, .max_distance = 0.8, .threads = {2}};
  Surface surface = extracted(dataset, options).surface;
  for (double& value : surface.isovalues) value = static_cast<double>(static_cast<float>(value));
  EXPECT_NE(surface.isovalues.front(), 90.3);
  Progress progress;
  const auto report = dataset.verify_surface(surface, options, progress);
  ASSERT_TRUE(report);
  for (const auto& check : report->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

TEST(many_isosurfaces, of_data_without_a_surface_are_empty) {
  for (const Volume& volume : {oracles::constant({{5, 6, 7}}, ScalarType::uint8, 3),
                               oracles::constant({{9, 9, 9}}, ScalarType::float32,
                                                 std::numeric_limits<float>::quiet_NaN()),
                               oracles::constant({{1, 1, 9}}, ScalarType::uint8, 3)}) {
    const Extracted all = extracted(test::built_dataset(volume),
                                    {.isovalues = {2, 3, 4}, .max_error = 1.0, .threads = {2}});
    EXPECT_TRUE(all.surface.is_empty());
    EXPECT_EQ(all.report.unmet.size(), 3U);
  }
}

TEST(many_isosurfaces, stop_when_cancelled) {
  const Dataset dataset = test::built_dataset(test::rough_volume<float>({{37, 35, 34}}, 0));
  Progress progress;
  progress.cancel();
  Surface surface;
  EXPECT_FALSE(dataset.extract({.isovalues = {90, 110}, .max_error = 1.0}, surface, progress));
}

}  // namespace
}  // namespace lode
