#include "lode/render/sampling.h"

#include <gtest/gtest.h>

namespace lode {
namespace {

const std::array<Vec3f, 4> kNormals{Vec3f{{0, 0, 1}}, Vec3f{{0, 0, -1}}, Vec3f{{1, 0, 0}},
                                    normalized(Vec3f{{0.3f, -0.5f, -0.8f}})};

TEST(sampling, tangents_make_a_right_handed_frame) {
  for (const Vec3f& n : kNormals) {
    const Tangents t = tangents_of(n);
    // A handful of roundings of numbers up to 1.
    EXPECT_NEAR(length(t.first), 1, 1e-6);
    EXPECT_NEAR(dot(t.first, n), 0, 1e-6);
    EXPECT_NEAR(length(cross(t.first, t.second) - n), 0, 1e-6);
  }
}

TEST(sampling, sky_directions_have_the_mean_of_a_cosine_density) {
  for (const Vec3f& n : kNormals) {
    const PixelSequence sequence(3, 5, 0);
    constexpr std::uint32_t kN = 4096;
    Vec3d mean;
    for (std::uint32_t i = 0; i < kN; ++i) {
      const auto u = sequence.at(i);
      const Vec3f d = cosine_direction(n, u[0], u[1]);
      EXPECT_NEAR(length(d), 1, 1e-5);
      mean = mean + Vec3d{{d[0], d[1], d[2]}} * (1.0 / kN);
    }
    // The mean of d is (2/3) n; random points would err by about 1 / sqrt(4096) = 0.016.
    EXPECT_NEAR(length(mean - Vec3d{{n[0], n[1], n[2]}} * (2.0 / 3)), 0, 0.016);
  }
}

TEST(sampling, sequences_stay_in_the_unit_cube_and_fill_it_evenly) {
  const PixelSequence sequence(11, 7, 2);
  std::array<int, 8> octants{};
  for (std::uint32_t i = 0; i < 800; ++i) {
    std::size_t octant = 0;
    const auto u = sequence.at(i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_GE(u[axis], 0.0f);
      ASSERT_LT(u[axis], 1.0f);
      octant |= static_cast<std::size_t>(u[axis] >= 0.5f) << axis;
    }
    ++octants[octant];
  }
  // Random points would stray by about sqrt(100) = 10.
  for (const int count : octants) EXPECT_NEAR(count, 100, 10);
}

TEST(sampling, pixels_and_streams_differ) {
  const auto a = PixelSequence(1, 2, 0).at(0);
  EXPECT_NE(a, PixelSequence(2, 1, 0).at(0));
  EXPECT_NE(a, PixelSequence(1, 2, 1).at(0));
  EXPECT_EQ(a, PixelSequence(1, 2, 0).at(0));
}

}  // namespace
}  // namespace lode
