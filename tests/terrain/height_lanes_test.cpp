// Passes over rows in vectors, held against one height at a time.
#include "lode/models/terrain/right_triangle_bisection/height_lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lode/delaunay/triangle_error.h"
#include "tests/oracles/random.h"

namespace lode::bisection {
namespace {

constexpr int kMostHeights = 90;

/// Whole numbers of steps, above `lowest`.
template <typename T>
std::vector<T> steps_of(int n, double per_unit, int lowest, oracles::Random& random) {
  std::vector<T> heights;
  for (int i = 0; i < n; ++i)
    heights.push_back(
        static_cast<T>((lowest + static_cast<double>(random.below(60'000))) / per_unit));
  return heights;
}

template <typename T>
void expect_range_and_steps(double per_unit) {
  const HeightLanes lanes = height_lanes();
  oracles::Random random(5);
  for (int n = 1; n < kMostHeights; ++n) {
    constexpr int kLowest = -3000;
    std::vector<T> heights = steps_of<T>(n, per_unit, kLowest, random);
    const HeightRange range = lanes.range(heights.data(), n);
    EXPECT_EQ(range.lower, static_cast<double>(*std::ranges::min_element(heights)));
    EXPECT_EQ(range.upper, static_cast<double>(*std::ranges::max_element(heights)));
    std::vector<std::uint16_t> steps(static_cast<std::size_t>(n) + 1, 777);
    const HeightLanes::Steps asked{per_unit, kLowest, 1e-9};
    EXPECT_TRUE(lanes.count_steps(heights.data(), n, asked, steps.data()));
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      EXPECT_EQ(steps[at], std::lround(static_cast<double>(heights[at]) * per_unit) - kLowest);
    }
    EXPECT_EQ(steps.back(), 777) << "beyond the row";
    heights[random.below(static_cast<std::uint32_t>(n))] += static_cast<T>(0.25 / per_unit);
    EXPECT_FALSE(lanes.count_steps(heights.data(), n, asked, steps.data())) << n;
  }
}

TEST(height_lanes, find_ranges_and_count_steps) {
  expect_range_and_steps<double>(1);
  expect_range_and_steps<double>(10);
  expect_range_and_steps<double>(100);
  expect_range_and_steps<double>(256);
  expect_range_and_steps<float>(1);
  expect_range_and_steps<float>(256);
}

TEST(height_lanes, turn_errors_into_units_and_tell_zeros) {
  const HeightLanes lanes = height_lanes();
  oracles::Random random(6);
  for (int n = 1; n < 200; ++n)
    for (const double unit : {0.1, 0.01, 1.0 / 256})
      for (const double slack : {0.0, 3e-11}) {
        std::vector<float> errors;
        for (int i = 0; i < n; ++i)
          errors.push_back(
              random.below(5) == 0 ? 0.0F : static_cast<float>(random.below(1 << 20)) / 16.0F);
        std::vector<float> turned = errors;
        turned.push_back(-7);
        std::vector<std::uint64_t> zeros(static_cast<std::size_t>(n) / 64 + 1, 0);
        lanes.to_units(turned.data(), n, unit, slack, zeros.data());
        EXPECT_EQ(turned.back(), -7) << "beyond the row";
        for (std::size_t i = 0; i < errors.size(); ++i) {
          EXPECT_EQ(turned[i],
                    delaunay::to_float_above(static_cast<double>(errors[i]) * unit + slack));
          EXPECT_EQ((zeros[i / 64] >> (i % 64) & 1) != 0, errors[i] == 0);
        }
      }
}

}  // namespace
}  // namespace lode::bisection
