#include "tests/oracles/hydrogen_atom.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/oracles/random.h"

namespace lode::oracles {
namespace {

TEST(hydrogen_density, integrates_to_one) {
  // Outside the ball of radius 40 lies Q = the chance of at most 6 events of a Poisson variable of
  // mean 2·40/3: under 2e-6. Sums over a lattice of step 1 miss what the density has at
  // frequencies of 2π and more, which falls with their eighth power: below 1e-5.
  double sum = 0;
  for (int z = -40; z <= 40; ++z)
    for (int y = -40; y <= 40; ++y)
      for (int x = -40; x <= 40; ++x) sum += hydrogen_density({{double(x), double(y), double(z)}});
  EXPECT_NEAR(sum, 1, 2e-5);
}

TEST(hydrogen_density, is_largest_in_its_lobes_and_a_quarter_of_that_on_its_ring) {
  const double largest = largest_hydrogen_density();
  // 4 · 6⁴ · exp(-4) / (81² · 6π)
  EXPECT_NEAR(largest, 4 * 1296 * 0.018315638888734179 / (6561 * 18.849555921538759), 1e-17);
  EXPECT_NEAR(hydrogen_density({{6, 0, 0}}), largest / 4, 1e-17);
  EXPECT_NEAR(hydrogen_density({{-3.6, 4.8, 0}}), largest / 4, 1e-17);
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    const Vec3d p{{random.uniform(-20, 20), random.uniform(-20, 20), random.uniform(-20, 20)}};
    EXPECT_LT(hydrogen_density(p), largest);
  }
}

TEST(hydrogen_density, vanishes_at_the_nucleus_and_on_its_nodal_cone) {
  EXPECT_EQ(hydrogen_density({{0, 0, 0}}), 0);
  // 3 z² = r²; the difference of two numbers of 75 is off by 2e-14 at most, and squared.
  EXPECT_LT(hydrogen_density({{5, 5, 5}}), 1e-30);
  EXPECT_LT(hydrogen_density({{0, 5 * std::sqrt(2.0), 5}}), 1e-30);
}

TEST(hydrogen_density, stays_the_same_when_turned_about_its_axis) {
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const double rho = random.uniform(0, 20), z = random.uniform(-20, 20);
    const double angle = random.uniform(0, 6.3);
    const double turned = hydrogen_density({{rho * std::cos(angle), rho * std::sin(angle), z}});
    EXPECT_NEAR(turned, hydrogen_density({{rho, 0, z}}), 1e-15);
  }
}

TEST(hydrogen_atom, is_its_own_mirror_image_along_every_axis) {
  const int n = 24;
  const Volume volume = hydrogen_atom(n);
  const auto at = [&](int x, int y, int z) {
    return volume.as<std::uint8_t>()[static_cast<std::size_t>((z * n + y) * n + x)];
  };
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        ASSERT_EQ(at(x, y, z), at(n - 1 - x, y, z));
        ASSERT_EQ(at(x, y, z), at(x, n - 1 - y, z));
        ASSERT_EQ(at(x, y, z), at(x, y, n - 1 - z));
        ASSERT_EQ(at(x, y, z), at(y, x, z));
      }
}

TEST(hydrogen_atom, has_the_values_of_the_density) {
  const int n = 49;  // a Bohr radius apart
  const Volume volume = hydrogen_atom(n);
  EXPECT_EQ(volume.info.grid.spacing, (Vec3d{{1, 1, 1}}));
  const auto samples = volume.as<std::uint8_t>();
  const auto at = [&](int x, int y, int z) {
    return int{samples[static_cast<std::size_t>(((z + 24) * n + y + 24) * n + x + 24)]};
  };
  EXPECT_EQ(at(0, 0, 0), 0);
  EXPECT_EQ(at(0, 0, 6), 255);
  EXPECT_EQ(at(0, 0, -6), 255);
  EXPECT_EQ(at(6, 0, 0), 64);    // 255 / 4
  EXPECT_EQ(at(0, 0, 12), 75);   // 255 · 2⁴ · exp(-4) = 74.7
  EXPECT_EQ(at(0, -12, 0), 19);  // and a quarter of it
  EXPECT_EQ(at(0, 0, 24), 0);    // 255 · 4⁴ · exp(-12) = 0.4
  EXPECT_EQ(at(24, 24, 24), 0);
}

}  // namespace
}  // namespace lode::oracles
