// Counting many isovalues in one pass must give what extracting each of them gives.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "lode/api/dataset.h"
#include "tests/models/all_targets.h"
#include "tests/models/built_dataset.h"
#include "tests/models/rough_volume.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/synthetic_volumes.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

CountReport counted(const Dataset& dataset, const std::vector<double>& isovalues, double max_error,
                    int threads) {
  Progress progress;
  auto report = dataset.count(
      {.isovalues = isovalues, .max_error = max_error, .threads = {threads}}, progress);
  if (!report) throw std::runtime_error(report.error().message);
  return *report;
}

void expect_what_extraction_gives(const Dataset& dataset, const std::vector<double>& isovalues,
                                  double max_error) {
  const CountReport all = counted(dataset, isovalues, max_error, 3);
  ASSERT_EQ(all.counts.size(), isovalues.size());
  EXPECT_EQ(all.max_error, max_error);
  Progress progress;
  Surface surface;
  std::uint64_t n_cells = 0;
  for (std::size_t i = 0; i < isovalues.size(); ++i) {
    ASSERT_TRUE(dataset.extract({.isovalues = {isovalues[i]},
                                 .max_error = max_error,
                                 .normals = Normals::off,
                                 .threads = {2}},
                                surface, progress));
    const IsovalueCount& count = all.counts[i];
    EXPECT_EQ(count.isovalue, isovalues[i]);
    EXPECT_EQ(count.triangles, surface.triangles.size()) << "at " << isovalues[i];
    EXPECT_EQ(count.lines, surface.lines.size()) << "at " << isovalues[i];
    EXPECT_EQ(count.vertices, surface.positions.size()) << "at " << isovalues[i];
    n_cells += count.triangles + count.lines;
  }
  if (max_error == 0) EXPECT_GT(n_cells, 0U);
}

/// Inside the range, at its ends, beyond it, and in no order; n has no divisor 7.
std::vector<double> some_isovalues(const Dataset& dataset, int n) {
  const DatasetInfo info = dataset.describe();
  std::vector<double> isovalues{info.range_max, info.range_min, info.range_max + 1,
                                info.range_min - 1};
  for (int i = 0; i < n; ++i)
    isovalues.push_back(info.range_min + (info.range_max - info.range_min) * (i * 7 % n) / n);
  return isovalues;
}

void expect_exact_counts(const Volume& volume) {
  const Dataset dataset = test::built_dataset(volume);
  const DatasetInfo info = dataset.describe();
  const double range = info.range_max - info.range_min;
  for (const double share : {0.0, 0.01, 0.1}) {
    SCOPED_TRACE(share);
    expect_what_extraction_gives(dataset, some_isovalues(dataset, 8), share * range);
  }
}

class isovalue_counts_shapes : public testing::TestWithParam<Index3> {};

TEST_P(isovalue_counts_shapes, are_those_of_the_surfaces) {
  expect_exact_counts(test::rough_volume<std::uint8_t>(GetParam(), 0));
  expect_exact_counts(test::rough_volume<float>(GetParam(), 0));
}

TEST_P(isovalue_counts_shapes, are_those_of_the_surfaces_in_noise) {
  expect_exact_counts(oracles::integer_noise(
      GetParam(), {.type = ScalarType::uint8, .seed = 4, .low = 0, .high = 3}));
}

TEST_P(isovalue_counts_shapes, are_those_of_the_surfaces_between_holes) {
  for (const double share : {0.0005, 0.1}) {
    SCOPED_TRACE(share);
    expect_exact_counts(test::rough_volume<float>(GetParam(), share));
  }
}

INSTANTIATE_TEST_SUITE_P(dims, isovalue_counts_shapes,
                         testing::Values(Index3{{2, 2, 2}}, Index3{{33, 7, 4}}, Index3{{34, 33, 5}},
                                         Index3{{65, 4, 34}}, Index3{{4, 3, 66}},
                                         oracles::trials<Index3>({{41, 67, 36}}, {{34, 40, 12}}),
                                         Index3{{97, 1, 45}}, Index3{{1, 131, 260}},
                                         Index3{{300, 129, 1}}));

TEST(isovalue_counts, are_those_of_the_surfaces_of_every_sample_type) {
  const auto dims = oracles::trials<Index3>({{37, 35, 34}}, {{37, 35, 9}});
  expect_exact_counts(test::rough_volume<std::int16_t>(dims, 0));
  expect_exact_counts(test::rough_volume<std::uint16_t>(dims, 0));
  expect_exact_counts(test::rough_volume<std::int32_t>(dims, 0));
  expect_exact_counts(test::rough_volume<double>(dims, 0));
  expect_exact_counts(test::rough_volume<double>(dims, 0.001));
  expect_exact_counts(oracles::checkerboard_of_extremes(dims, ScalarType::int16));
}

TEST(isovalue_counts, are_those_of_the_surfaces_of_a_field_whose_coarse_leaves_suffice) {
  expect_exact_counts(oracles::linear_ramp({{130, 66, 97}}, ScalarType::float32, {{1, 0.5, 0.25}}));
  expect_exact_counts(oracles::sample(oracles::Field::gaussians40, 65));
}

TEST(isovalue_counts, hold_for_more_isovalues_than_ranks_fit_in_a_byte) {
  const Dataset dataset = test::built_dataset(test::rough_volume<float>({{33, 20, 11}}, 0));
  for (const double max_error : {0.0, 2.0})
    expect_what_extraction_gives(dataset, some_isovalues(dataset, 300), max_error);
}

TEST(isovalue_counts, do_not_depend_on_threads_or_on_the_processor) {
  const Dataset dataset = test::built_dataset(test::rough_volume<std::uint8_t>({{41, 67, 36}}, 0));
  const std::vector<double> isovalues = some_isovalues(dataset, 50);
  for (const double max_error : {0.0, 2.0}) {
    const CountReport expected = counted(dataset, isovalues, max_error, 1);
    const auto expect_the_same = [&](int threads) {
      const CountReport report = counted(dataset, isovalues, max_error, threads);
      for (std::size_t i = 0; i < isovalues.size(); ++i) {
        EXPECT_EQ(report.counts[i].triangles, expected.counts[i].triangles);
        EXPECT_EQ(report.counts[i].vertices, expected.counts[i].vertices);
      }
    };
    for (const int threads : {2, 3, 7}) expect_the_same(threads);
    test::for_each_target([&] { expect_the_same(2); });
  }
}

TEST(isovalue_counts, are_zero_without_cells_or_values) {
  for (const Volume& volume : {oracles::constant({{5, 6, 7}}, ScalarType::uint8, 3),
                               oracles::constant({{9, 9, 9}}, ScalarType::float32,
                                                 std::numeric_limits<float>::quiet_NaN()),
                               oracles::constant({{1, 1, 9}}, ScalarType::uint8, 3)}) {
    const Dataset dataset = test::built_dataset(volume);
    for (const double max_error : {0.0, 1.0})
      for (const IsovalueCount& count : counted(dataset, {3, 3, 2.5}, max_error, 2).counts) {
        EXPECT_EQ(count.triangles + count.lines, 0U);
        EXPECT_EQ(count.vertices, 0U);
      }
  }
}

TEST(isovalue_counts, refuse_what_has_no_answer) {
  const Dataset dataset = test::built_dataset(oracles::constant({{5, 6, 7}}, ScalarType::uint8, 3));
  Progress progress;
  EXPECT_FALSE(dataset.count({.isovalues = {}}, progress));
  EXPECT_FALSE(dataset.count({.isovalues = {1, std::nan("")}}, progress));
  EXPECT_FALSE(dataset.count({.isovalues = {1}, .max_error = -1}, progress));
}

TEST(isovalue_counts, stop_when_cancelled) {
  const Dataset dataset = test::built_dataset(test::rough_volume<float>({{37, 35, 34}}, 0));
  for (const double max_error : {0.0, 1.0}) {
    Progress progress;
    progress.cancel();
    EXPECT_FALSE(dataset.count({.isovalues = {90, 100}, .max_error = max_error}, progress));
  }
}

}  // namespace
}  // namespace lode
