#include "lode/models/diamond/range_code.h"

#include <gtest/gtest.h>

#include "tests/oracles/random.h"

namespace lode::diamond {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::array<float, 2> kAll{-kInfinity, kInfinity};

/// A float32 of any size and sign; now and then one of the odd ones.
float any_float(oracles::Random& random) {
  constexpr std::array kOdd{0.0F,
                            kInfinity,
                            -kInfinity,
                            std::numeric_limits<float>::max(),
                            std::numeric_limits<float>::lowest(),
                            std::numeric_limits<float>::min(),
                            std::numeric_limits<float>::denorm_min()};
  if (random.below(8) == 0) return kOdd[random.below(kOdd.size())];
  const auto sign = random.below(2) == 0 ? 1.0F : -1.0F;
  const auto exponent = static_cast<int>(random.below(277)) - 149;
  return sign * std::ldexp(static_cast<float>(random.uniform(1, 2)), std::min(exponent, 127));
}

std::array<float, 2> rounded(std::array<float, 2> range, const std::array<float, 2>& whole) {
  round_range(whole, range[0], range[1]);
  return range;
}

bool contains(const std::array<float, 2>& a, const std::array<float, 2>& b) {
  return a[0] <= b[0] && b[1] <= a[1];
}

TEST(range_code, rounding_is_outward_by_a_64th_at_most_and_keeps_inside_what_was) {
  oracles::Random random(1);
  for (int i = 0; i < 200000; ++i) {
    // Four values in order: two ranges, one in the other; ends of both may be equal.
    std::array<float, 4> x{};
    const float scale = any_float(random);
    for (float& value : x)
      value = i % 2 == 0 ? any_float(random) : scale + static_cast<float>(random.below(9));
    std::sort(x.begin(), x.end());
    const std::array<float, 2> whole = i % 3 == 0 ? std::array{x[0], x[3]} : kAll;
    const std::array outer{x[0], x[3]};
    const std::array inner{x[1 - random.below(2)], x[2 + random.below(2)]};
    const auto around = rounded(outer, whole);
    const auto inside = rounded(inner, whole);
    ASSERT_TRUE(contains(around, outer) && contains(inside, inner)) << x[0] << " " << x[3];
    ASSERT_TRUE(contains(around, inside)) << x[0] << " " << x[1] << " " << x[2] << " " << x[3];
    ASSERT_TRUE(contains(whole, around));
    const double width = static_cast<double>(outer[1]) - static_cast<double>(outer[0]);
    if (!std::isfinite(width) || std::isinf(around[0]) || std::isinf(around[1])) continue;
    ASSERT_LE(static_cast<double>(outer[0]) - static_cast<double>(around[0]), width / 64);
    ASSERT_LE(static_cast<double>(around[1]) - static_cast<double>(outer[1]), width / 64);
  }
}

TEST(range_code, rounding_leaves_empty_ranges_and_single_values) {
  EXPECT_EQ(rounded({kInfinity, -kInfinity}, kAll), (std::array{kInfinity, -kInfinity}));
  EXPECT_EQ(rounded({0.1F, 0.1F}, kAll), (std::array{0.1F, 0.1F}));
  EXPECT_EQ(rounded({-kInfinity, -kInfinity}, kAll), (std::array{-kInfinity, -kInfinity}));
}

TEST(range_code, rounding_makes_multiples_of_powers_of_two) {
  EXPECT_EQ(rounded({0.3F, 100.3F}, kAll), (std::array{0.0F, 101.0F}));
  EXPECT_EQ(rounded({-0.3F, 100.3F}, kAll), (std::array{-1.0F, 101.0F}));
  EXPECT_EQ(rounded({-0.3F, 100.3F}, {-0.3F, 100.5F}), (std::array{-0.3F, 100.5F}));
}

}  // namespace
}  // namespace lode::diamond
