#include "lode/io/border_plan.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace lode::io {
namespace {

/// Parts of 256 samples with border layers as a build in parts of a 3D field has them.
std::vector<IndexRange> parts_of(std::int32_t n) {
  std::vector<IndexRange> parts;
  for (std::int32_t lower = 0; lower < n; lower += 256)
    parts.push_back({std::max(0, lower - 16), std::min(n, lower + 256 + 17)});
  return parts;
}

/// What is read of an axis, and written to and read from the spool, for one walk part by part.
double bytes_moved(const AxisReads& reads, const BorderPlan& plan) {
  double n = 0;
  for (const IndexRange& kept : plan.kept()) n += kept.size();
  for (std::size_t part = 0; part < reads.parts.size(); ++part) {
    std::int32_t last_unit = -1;
    for (const auto& run : plan.runs_of(reads.parts[part], static_cast<int>(part))) {
      if (run.kept != BorderPlan::Run::kFromSource) {
        n += run.range.size();
        continue;
      }
      const std::int32_t first = std::max(run.range.lower / reads.unit, last_unit + 1);
      last_unit = (run.range.upper - 1) / reads.unit;
      n += reads.stored_share * (last_unit + 1 - first) * reads.unit;
    }
  }
  return n;
}

class border_plan : public ::testing::TestWithParam<std::int32_t> {};

TEST_P(border_plan, finds_each_sample_once_and_moves_no_more_than_reading_again) {
  const AxisReads reads{parts_of(2500), GetParam(), 1};
  const BorderPlan plan(reads);
  for (std::size_t part = 0; part < reads.parts.size(); ++part) {
    std::int32_t next = reads.parts[part].lower;
    for (const auto& run : plan.runs_of(reads.parts[part], static_cast<int>(part))) {
      EXPECT_EQ(run.range.lower, next);
      EXPECT_LT(run.range.lower, run.range.upper);
      next = run.range.upper;
      if (run.kept == BorderPlan::Run::kFromSource) continue;
      const IndexRange& kept = plan.kept()[static_cast<std::size_t>(run.kept)];
      EXPECT_LE(kept.lower, run.range.lower);
      EXPECT_GE(kept.upper, run.range.upper);
    }
    EXPECT_EQ(next, reads.parts[part].upper);
  }
  EXPECT_LE(bytes_moved(reads, plan), bytes_moved(reads, BorderPlan()));
  // Of each 256 samples 33 lie in border layers: written once, read once.
  if (256 % GetParam() == 0) {
    EXPECT_LE(bytes_moved(reads, plan), (1 + 2 * 33. / 256) * (2500 + GetParam()));
  }
}

INSTANTIATE_TEST_SUITE_P(units, border_plan,
                         ::testing::Values(1, 2, 16, 33, 64, 100, 128, 200, 256, 300, 512, 1000,
                                           1024, 5000));

TEST(border_plan, keeps_nothing_where_reading_again_moves_fewer_bytes) {
  EXPECT_TRUE(BorderPlan({parts_of(1000), 1, 1}).kept().empty());
  EXPECT_TRUE(BorderPlan({parts_of(1000), 64, 0.25}).kept().empty());  // compressed to a quarter
  EXPECT_TRUE(BorderPlan({parts_of(256), 64, 1}).kept().empty());      // one part
  EXPECT_FALSE(BorderPlan({parts_of(1000), 64, 1}).kept().empty());
}

TEST(border_plan, has_one_part_decode_a_unit_between_two) {
  const BorderPlan plan({parts_of(512), 128, 1});
  const std::vector<IndexRange> kept(plan.kept().begin(), plan.kept().end());
  EXPECT_EQ(kept, (std::vector<IndexRange>{{240, 256}, {256, 273}}));
  EXPECT_EQ(plan.runs_of({0, 273}, 0).size(), 2U);
  EXPECT_EQ(plan.runs_of({240, 512}, 1).size(), 2U);
}

}  // namespace
}  // namespace lode::io
