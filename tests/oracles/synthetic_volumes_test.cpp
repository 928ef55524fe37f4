#include "tests/oracles/synthetic_volumes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"

namespace lode::oracles {
namespace {

TEST(random, repeats_the_published_splitmix64_sequence) {
  Random random(1234567);
  EXPECT_EQ(random.next(), 6457827717110365317U);
  EXPECT_EQ(random.next(), 3203168211198807973U);
  EXPECT_EQ(random.next(), 9817491932198370423U);
}

TEST(linear_ramp, follows_its_slope) {
  const Volume volume = linear_ramp({{3, 4, 5}}, ScalarType::int32, {{1, 10, 100}}, -7);
  const auto samples = volume.as<std::int32_t>();
  EXPECT_EQ(samples.front(), -7);
  EXPECT_EQ(samples[1], -6);
  EXPECT_EQ(samples[3], 3);
  EXPECT_EQ(samples.back(), 2 + 30 + 400 - 7);
}

TEST(constant, is_the_same_everywhere) {
  const Volume volume = constant({{4, 3, 2}}, ScalarType::uint8, 42);
  EXPECT_EQ(std::ranges::count(volume.as<std::uint8_t>(), 42), 24);
}

TEST(checkerboard, alternates_along_every_axis) {
  const Volume volume = checkerboard({{2, 2, 2}}, ScalarType::float32, 1, -1);
  const auto s = volume.as<float>();
  EXPECT_EQ(std::vector<float>(s.begin(), s.end()),
            (std::vector<float>{1, -1, -1, 1, -1, 1, 1, -1}));
}

TEST(checkerboard_of_extremes, reaches_both_ends_of_integers) {
  const Volume volume = checkerboard_of_extremes({{2, 1, 1}}, ScalarType::int64);
  const auto samples = volume.as<std::int64_t>();
  EXPECT_EQ(samples[0], std::numeric_limits<std::int64_t>::lowest());
  EXPECT_EQ(samples[1], std::numeric_limits<std::int64_t>::max());
}

TEST(checkerboard_of_extremes, keeps_differences_of_floats_finite) {
  const Volume volume = checkerboard_of_extremes({{2, 1, 1}}, ScalarType::float64);
  const auto samples = volume.as<double>();
  EXPECT_TRUE(std::isfinite(samples[1] - samples[0]));
}

TEST(noise, is_the_same_for_the_same_seed_and_differs_for_another) {
  const Index3 dims{{7, 6, 5}};
  const NoiseOptions first{.seed = 3}, second{.seed = 4};
  EXPECT_EQ(noise(dims, first).samples, noise(dims, first).samples);
  EXPECT_NE(noise(dims, first).samples, noise(dims, second).samples);
}

TEST(noise, stays_inside_its_interval) {
  const Volume volume = noise({{20, 20, 20}}, {.type = ScalarType::float64, .low = -3, .high = 5});
  const auto [low, high] = std::ranges::minmax(volume.as<double>());
  EXPECT_GE(low, -3);
  EXPECT_LT(high, 5);
  EXPECT_LT(low, -2.9);
  EXPECT_GT(high, 4.9);
}

TEST(integer_noise, takes_every_level_about_equally_often) {
  const Volume volume =
      integer_noise({{30, 30, 30}}, {.type = ScalarType::uint8, .low = 2, .high = 4});
  // 27000 samples, three levels: standard deviation sqrt(27000 · 2/9) ≈ 77; six of them.
  for (const int level : {2, 3, 4}) {
    const auto n = std::ranges::count(volume.as<std::uint8_t>(), level);
    EXPECT_NEAR(static_cast<double>(n), 9000.0, 465.0) << "level " << level;
  }
}

TEST(to_sample, rounds_and_clamps) {
  EXPECT_EQ(to_sample<std::uint8_t>(2.5), 3);
  EXPECT_EQ(to_sample<std::uint8_t>(-1), 0);
  EXPECT_EQ(to_sample<std::int8_t>(1e9), 127);
  EXPECT_EQ(to_sample<std::uint64_t>(1e30), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(to_sample<std::int64_t>(-1e30), std::numeric_limits<std::int64_t>::lowest());
}

}  // namespace
}  // namespace lode::oracles
