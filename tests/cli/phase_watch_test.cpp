// What the line of progress says: bytes, rate and time left.
#include "lode/api/phase_watch.h"

#include <gtest/gtest.h>

namespace lode::test {
namespace {

constexpr std::uint64_t kBytes = 4'000'000'000;

TEST(phase_watch, tells_bytes_rate_and_time_left) {
  PhaseWatch watch;
  PhaseWatch::Outlook outlook = watch.update("building", 0, kBytes, 100);
  EXPECT_EQ(outlook.n_bytes_done, 0U);
  EXPECT_FALSE(outlook.bytes_a_second || outlook.seconds_left) << "there is nothing to go by";
  outlook = watch.update("building", 0.001, kBytes, 100.1);
  EXPECT_FALSE(outlook.seconds_left) << "a tenth of a second says little";
  outlook = watch.update("building", 0.25, kBytes, 110);
  EXPECT_EQ(outlook.n_bytes_done, 1'000'000'000U);
  EXPECT_DOUBLE_EQ(*outlook.bytes_a_second, 1e8);
  EXPECT_DOUBLE_EQ(*outlook.seconds_left, 30);
}

TEST(phase_watch, begins_anew_with_each_phase_and_counts_no_work_of_earlier_runs) {
  PhaseWatch watch;
  watch.update("reading", 0, kBytes, 0);
  watch.update("reading", 1, kBytes, 50);
  watch.update("building", 0.5, kBytes, 50);  // a build that is resumed
  const PhaseWatch::Outlook outlook = watch.update("building", 0.75, kBytes, 60);
  EXPECT_EQ(outlook.n_bytes_done, 3'000'000'000U);
  EXPECT_DOUBLE_EQ(*outlook.bytes_a_second, 1e8);
  EXPECT_DOUBLE_EQ(*outlook.seconds_left, 10);
}

TEST(phase_watch, has_no_rate_where_bytes_mean_nothing) {
  PhaseWatch watch;
  watch.update("refining", 0, 0, 0);
  const PhaseWatch::Outlook outlook = watch.update("refining", 0.5, 0, 4);
  EXPECT_EQ(outlook.n_bytes_done, 0U);
  EXPECT_FALSE(outlook.bytes_a_second);
  EXPECT_DOUBLE_EQ(*outlook.seconds_left, 4);
}

}  // namespace
}  // namespace lode::test
