#include "lode/core/ellipsoid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/oracles/random.h"

namespace lode {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

double length(double lon, double lat, double lon_to, double lat_to,
              const Ellipsoid& ellipsoid = kWgs84Ellipsoid) {
  return length_on(ellipsoid, {{lon * kDegree, lat * kDegree}},
                   {{lon_to * kDegree, lat_to * kDegree}});
}

TEST(ellipsoid, has_the_known_lengths_of_wgs_84) {
  // The quarter meridian, 10 001 965.729 m (NIMA TR8350.2), and a degree of the equator.
  EXPECT_NEAR(length(0, 0, 0, 90), 10001965.7293, 1e-4);
  EXPECT_NEAR(length(10, 0, 11, 0), 6378137 * kDegree, 1e-8);
  // A parallel is a circle.
  const double e2 = (2 - 1 / 298.257223563) / 298.257223563;
  const double radius =
      6378137 * std::cos(60 * kDegree) / std::sqrt(1 - e2 * std::pow(std::sin(60 * kDegree), 2));
  EXPECT_NEAR(length(-170, 60, 170, 60), radius * 340 * kDegree, 1e-6);
  EXPECT_NEAR(kWgs84Ellipsoid.mean_radius(), 6371008.7714, 1e-4);
}

TEST(ellipsoid, of_no_flattening_is_a_sphere) {
  const Ellipsoid sphere{1000, 0};
  EXPECT_NEAR(length(0, -90, 0, 90, sphere), 1000 * std::numbers::pi, 1e-9);
  EXPECT_EQ(sphere.mean_radius(), 1000);
}

TEST(ellipsoid, lengths_add_up_and_are_symmetric) {
  oracles::Random random(11);
  for (int i = 0; i < 200; ++i) {
    const double lon = random.uniform(-180, 180);
    const double lat = random.uniform(-89, 89);
    const double lon_to = random.uniform(-180, 180);
    const double lat_to = random.uniform(-89, 89);
    const double whole = length(lon, lat, lon_to, lat_to);
    double sum = 0;
    // Of pieces 7 times as short the rule's error is below any rounding.
    constexpr int kParts = 7 * 180;
    for (int k = 0; k < kParts; ++k) {
      const double from = static_cast<double>(k) / kParts;
      const double to = static_cast<double>(k + 1) / kParts;
      sum += length(lon + from * (lon_to - lon), lat + from * (lat_to - lat),
                    lon + to * (lon_to - lon), lat + to * (lat_to - lat));
    }
    EXPECT_NEAR(sum / whole, 1, 1e-12);
    EXPECT_NEAR(length(lon_to, lat_to, lon, lat) / whole, 1, 1e-14);
  }
  EXPECT_EQ(length(7, 45, 7, 45), 0);
}

}  // namespace
}  // namespace lode
