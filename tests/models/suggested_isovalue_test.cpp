#include "lode/api/suggested_isovalue.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using oracles::volume_of;

RegularGrid cube_of(std::int32_t n) {
  RegularGrid grid;
  grid.dims = {{n, n, n}};
  return grid;
}

double suggested(const Volume& volume) {
  Progress progress;
  const auto dataset = Dataset::build(*make_memory_source(volume), {.threads = {2}}, progress);
  EXPECT_TRUE(dataset);
  const auto isovalue = suggest_isovalue(*dataset, progress);
  EXPECT_TRUE(isovalue);
  return isovalue->value_or(std::nan(""));
}

/// A ball of about `inside` in about `outside`.
template <typename T>
Volume ball(double inside, double outside) {
  return volume_of<T>(cube_of(40), [&](const Index3& p) {
    const double x = p[0] - 19.5;
    const double y = p[1] - 19.5;
    const double z = p[2] - 19.5;
    const double noise = (p[0] * 7 + p[1] * 13 + p[2] * 29) % 10;
    return (x * x + y * y + z * z < 150 ? inside : outside) + noise;
  });
}

TEST(suggested_isovalue, lies_between_what_there_is_of_both) {
  for (const auto& [inside, outside] : {std::pair{200.0, 20.0}, {30.0, 180.0}, {90.0, 60.0}}) {
    const double isovalue = suggested(ball<std::uint8_t>(inside, outside));
    EXPECT_GT(isovalue, std::min(inside, outside) + 9);
    EXPECT_LT(isovalue, std::max(inside, outside));
    // Between two whole numbers: no sample has it.
    EXPECT_EQ(isovalue - std::floor(isovalue), 0.5);
  }
  const double small = suggested(ball<float>(1e-3, 1e3));
  EXPECT_GT(small, 10);
  EXPECT_LT(small, 1e3);
}

TEST(suggested_isovalue, is_there_where_there_are_two_parts) {
  EXPECT_TRUE(std::isnan(suggested(volume_of<float>(cube_of(5), [](const Index3&) { return 7; }))));
  RegularGrid line;
  line.dims = {{9, 1, 1}};
  EXPECT_TRUE(std::isnan(suggested(volume_of<float>(line, [](const Index3& p) { return p[0]; }))));
  EXPECT_TRUE(std::isnan(
      suggested(volume_of<float>(cube_of(5), [](const Index3&) { return std::nan(""); }))));
  const double ramp = suggested(volume_of<float>(cube_of(9), [](const Index3& p) { return p[0]; }));
  EXPECT_NEAR(ramp, 4, 0.1);
  RegularGrid flat;
  flat.dims = {{30, 20, 1}};
  const double half = suggested(
      volume_of<std::int16_t>(flat, [](const Index3& p) { return p[0] < 15 ? -100 : 100; }));
  EXPECT_GT(half, -100);
  EXPECT_LT(half, 100);
}

}  // namespace
}  // namespace lode
