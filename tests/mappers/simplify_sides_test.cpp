#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "lode/mappers/simplify_surface.h"
#include "lode/mappers/surface_checks.h"
#include "tests/mappers/point_band.h"
#include "tests/mappers/shape_surfaces.h"

namespace lode {
namespace {

using test::PointBand;
using test::winding;

class SimplifySides : public testing::TestWithParam<std::tuple<unsigned, unsigned>> {};

INSTANTIATE_TEST_SUITE_P(all, SimplifySides,
                         testing::Combine(testing::Values(0U, 3U, 20U), testing::Range(0U, 12U)));

TEST_P(SimplifySides, no_sample_outside_the_band_changes_sides) {
  const auto [failing_percent, seed] = GetParam();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  Surface surface =
      seed % 2 == 0 ? test::make_torus(40, 18, 5, 2) : test::make_sphere(16, 4, {{1, 2, 3}});
  for (Vec3f& p : surface.positions)
    for (float& x : p.v) x += static_cast<float>(0.2 * shift(random));
  std::vector<Vec3d> points(150);
  for (Vec3d& p : points) {
    p = widened(surface.positions[random() % surface.positions.size()]);
    for (double& x : p.v) x += 0.7 * shift(random);
  }
  const PointBand band(points, failing_percent);
  Surface simple = surface;
  Progress progress;
  const auto report = simplify_surface(
      simple,
      {.max_distance = std::numeric_limits<double>::infinity(), .band = &band, .threads = {2}},
      progress);
  ASSERT_TRUE(report);
  EXPECT_LT(simple.triangles.size(), surface.triangles.size());
  if (failing_percent > 0) {
    EXPECT_GT(report->undone, 0U);
  }
  for (const Vec3d& p : points) EXPECT_EQ(winding(simple, p), winding(surface, p));
  EXPECT_EQ(check_topology(simple, {}).euler_number, check_topology(surface, {}).euler_number);
  EXPECT_TRUE(check_topology(simple, {}).is_clean_manifold());
}

}  // namespace
}  // namespace lode
