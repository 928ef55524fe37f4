#include "lode/core/point_triangle.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/oracles/random.h"

namespace lode {
namespace {

Vec3d random_vec(oracles::Random& random) {
  return {{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}};
}

/// Points over the inside of a triangle, so high that they are nearest to their feet.
TEST(point_triangle, distances_from_thin_triangles_are_as_near_as_from_thick_ones) {
  oracles::Random random(5);
  for (const double thickness : {1.0, 1e-3, 1e-5, 1e-7})
    for (int trial = 0; trial < 1000; ++trial) {
      const Vec3d a = random_vec(random);
      const Vec3d u = random_vec(random);
      const Vec3d other = random_vec(random);
      const Vec3d across = other - u * (dot(other, u) / dot(u, u));
      const Vec3d v = u * random.uniform(-0.5, 1.5) + across * thickness;
      const Vec3d normal = cross(u, across) * (1 / length(cross(u, across)));
      double s = random.uniform(0.05, 0.95);
      double r = random.uniform(0.05, 0.95);
      if (s + r > 0.95) {
        s = (1 - s) * 0.9;
        r = (1 - r) * 0.9;
      }
      const double height = trial % 2 == 0 ? 0 : thickness * random.uniform(0, 1e-3);
      const Vec3d p = a + u * s + v * r + normal * height;
      const double found = std::sqrt(squared_distance_to_triangle<double>(p, {a, a + u, a + v}));
      EXPECT_NEAR(found, height, 1e-9)
          << thickness;  // Where edges are 1e-3 apart, products round so much.
    }
}

TEST(point_triangle, distances_from_triangles_without_area_are_those_from_their_edges) {
  const Vec3d a{{0, 0, 0}};
  const Vec3d b{{2, 0, 0}};
  EXPECT_EQ(squared_distance_to_triangle<double>({{1, 3, 0}}, {a, b, {{1, 0, 0}}}), 9);
  EXPECT_EQ(squared_distance_to_triangle<double>({{5, 4, 0}}, {a, b, b}), 25);
  EXPECT_EQ(squared_distance_to_triangle<double>({{3, 4, 0}}, {a, a, a}), 25);
}

}  // namespace
}  // namespace lode
