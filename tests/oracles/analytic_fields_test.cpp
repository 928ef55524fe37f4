#include "tests/oracles/analytic_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/oracles/random.h"

namespace lode::oracles {
namespace {

class analytic_field : public testing::TestWithParam<Field> {};

TEST_P(analytic_field, has_the_gradient_of_its_value) {
  Random random(7);
  // Central differences err by h²/6 · |third derivative| plus about 1e-16/h: the steepest field
  // (marschner_lobb, third derivatives up to about (2 pi f pi/2)³ · 0.1 ≈ 2e4) stays below 1e-6.
  const double h = 1e-5;
  for (int i = 0; i < 1000; ++i) {
    const Vec3d p{{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}};
    if (length(p) < 0.05) continue;  // the sphere has no gradient at its centre
    const Vec3d g = gradient(GetParam(), p);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3d before = p, after = p;
      before[axis] -= h;
      after[axis] += h;
      const double slope = (value(GetParam(), after) - value(GetParam(), before)) / (2 * h);
      EXPECT_NEAR(slope, g[axis], 1e-5) << "axis " << axis << ", sample " << i;
    }
  }
}

TEST_P(analytic_field, samples_are_its_values_to_the_bit) {
  const Index3 dims{{9, 5, 3}};
  const Volume volume = sample(GetParam(), dims, {.type = ScalarType::float64});
  ASSERT_EQ(volume.info.grid.dims, dims);
  const auto samples = volume.as<double>();
  // Powers of two as intervals: world coordinates are exact.
  std::size_t i = 0;
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (std::int32_t x = 0; x < dims[0]; ++x) {
        const Vec3d index{{double(x), double(y), double(z)}};
        EXPECT_EQ(samples[i++], value(GetParam(), volume.info.grid.to_world(index)));
      }
}

TEST_P(analytic_field, meets_its_usual_isovalue) {
  const Volume volume = sample(GetParam(), 33);
  const auto [low, high] = std::ranges::minmax(volume.as<float>());
  EXPECT_LT(low, usual_isovalue(GetParam()));
  EXPECT_GT(high, usual_isovalue(GetParam()));
}

TEST_P(analytic_field, fills_every_scalar_type_with_the_scaled_range) {
  for (const ScalarType type : {ScalarType::uint8, ScalarType::int16, ScalarType::uint16,
                                ScalarType::int32, ScalarType::uint64, ScalarType::float64}) {
    const Volume volume =
        sample(GetParam(), {{5, 4, 3}}, {.type = type, .scale = 10, .offset = 50});
    EXPECT_EQ(volume.info.type, type);
    EXPECT_EQ(volume.samples.size(), 60 * size_of(type));
  }
}

INSTANTIATE_TEST_SUITE_P(all, analytic_field, testing::ValuesIn(kFields),
                         [](const auto& test) { return std::string(name_of(test.param)); });

TEST(gaussians40, has_the_documented_range_at_257) {
  const Volume volume = sample(Field::gaussians40, 257);
  const auto [low, high] = std::ranges::minmax(volume.as<float>());
  EXPECT_NEAR(low, 1.3e-5, 0.05e-5);
  EXPECT_NEAR(high, 3.037, 0.0005);
}

TEST(field_grid, puts_a_lone_sample_in_the_middle) {
  const RegularGrid grid = field_grid({{1, 3, 2}});
  EXPECT_EQ(grid.to_world({{0, 2, 1}}), (Vec3d{{0, 1, 1}}));
}

}  // namespace
}  // namespace lode::oracles
