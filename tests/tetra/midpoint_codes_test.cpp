// Codes of positions and values, of which midpoints are exact.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lode/models/tetra_mt/midpoint/codes.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::tetra_mt::midpoint {
namespace {

using oracles::Random;

TEST(midpoint_codes, go_to_the_middle_and_back_without_loss) {
  Random random(3);
  const auto any = [&] {
    Code code;
    for (std::int32_t& c : code) c = static_cast<std::int32_t>(random.below(0x80000000U));
    return code;
  };
  for (int i = 0; i < 2000; ++i) {
    Code a = any();
    Code b = any();
    if (i % 7 == 0) a = {0, 0x7FFFFFFF, 0, 1};
    if (i % 7 == 0) b = {0x7FFFFFFF, 0, 1, 0};
    for (const Place position : {Place::middle, Place::first, Place::second})
      for (const Place value : {Place::middle, Place::first, Place::second}) {
        const Code made = merged(a, b, {position, value});
        Code way;
        for (std::size_t axis = 0; axis < 4; ++axis) way[axis] = difference(a[axis], b[axis]);
        const Ends ends = parted(made, way, {position, value});
        EXPECT_EQ(ends.first, a);
        EXPECT_EQ(ends.second, b);
        if (position != Place::middle) continue;
        const std::int64_t sum = std::int64_t{a[0]} + b[0];
        EXPECT_EQ(made[0], sum >> 1);
      }
  }
}

TEST(midpoint_codes, are_off_by_no_more_than_is_said) {
  Random random(5);
  for (int i = 0; i < 500; ++i) {
    const double centre =
        std::ldexp(random.uniform(-1, 1), static_cast<int>(random.below(600)) - 300);
    const double width =
        std::abs(centre) * std::ldexp(1.0, static_cast<int>(random.below(40)) - 20);
    const Scale scale(centre - width, centre + width);
    for (int k = 0; k <= 4; ++k) {
      const double x = centre + width * (k / 2.0 - 1);
      EXPECT_LE(std::abs(scale.value(scale.code(x)) - x), 0x1p-31 * 2 * width);
    }
  }
  for (const double x : {0.0, 1e-320, -1e308, 5.0}) {
    const Scale scale(x, x);
    EXPECT_EQ(scale.value(scale.code(x)), x);
  }
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint
