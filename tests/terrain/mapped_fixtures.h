#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <utility>

#include "lode/api/files.h"
#include "lode/core/place_map.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode::test {

class FunctionMap final : public PlaceMap {
 public:
  explicit FunctionMap(std::function<Place(const Place&)> function)
      : function_(std::move(function)) {}
  void apply(std::span<Place> places) const override {
    for (Place& place : places) place = function_(place);
  }
  [[nodiscard]] std::unique_ptr<const PlaceMap> copy() const override {
    return std::make_unique<FunctionMap>(function_);
  }

 private:
  std::function<Place(const Place&)> function_;
};

/// Universal Transverse Mercator of WGS 84 by Krueger's series (1912) up to n^4, which is short of
/// the projection by terms of n^5 = 1.3e-14 of the earth's radius, 1e-7 m.
inline Place to_utm(const Place& degrees, double central) {
  constexpr double kRadian = std::numbers::pi / 180;
  const double f = 1 / 298.257223563;
  const double n = f / (2 - f);
  const double n2 = n * n;
  const double radius = 6378137 / (1 + n) * (1 + n2 / 4 + n2 * n2 / 64);
  const std::array<double, 4> alpha{n / 2 - 2 * n2 / 3 + 5 * n2 * n / 16 + 41 * n2 * n2 / 180,
                                    13 * n2 / 48 - 3 * n2 * n / 5 + 557 * n2 * n2 / 1440,
                                    61 * n2 * n / 240 - 103 * n2 * n2 / 140,
                                    49561 * n2 * n2 / 161280};
  const double s = std::sin(degrees[1] * kRadian);
  const double l = (degrees[0] - central) * kRadian;
  const double e = 2 * std::sqrt(n) / (1 + n);
  const double t = std::sinh(std::atanh(s) - e * std::atanh(e * s));
  const double xi = std::atan(t / std::cos(l));
  const double eta = std::atanh(std::sin(l) / std::hypot(1, t));
  Place sum{{eta, xi}};
  for (std::size_t j = 0; j < 4; ++j) {
    const double k = 2 * (static_cast<double>(j) + 1);
    sum[0] += alpha[j] * std::cos(k * xi) * std::sinh(k * eta);
    sum[1] += alpha[j] * std::sin(k * xi) * std::cosh(k * eta);
  }
  return {{500000 + 0.9996 * radius * sum[0], 0.9996 * radius * sum[1]}};
}

inline TargetCrs open_target(const std::string& source, const std::string& target,
                             const Place& middle = {{9, 46}}) {
  auto made = open_target_crs(source, target, middle);
  if (!made) ADD_FAILURE() << made.error().message;
  return std::move(made).value();
}

inline double waves(std::int32_t x, std::int32_t y) {
  return std::round(800 * std::sin(0.17 * x) * std::cos(0.13 * y) + 30 * std::sin(1.3 * x + y));
}

/// Two hundredths of a degree apart, rows from the north; some are missing.
inline std::shared_ptr<const HeightGrid> degree_grid() {
  HeightGrid grid = delaunay::test::make_grid<std::int16_t>(60, 50, waves);
  grid.to_world = {7.01, 0.02, 0, 46.99, 0, -0.02};
  grid.crs = "EPSG:4326";
  for (std::int32_t i = 0; i < 40; ++i) delaunay::test::set_missing(grid, 20 + i % 8, 11 + i / 8);
  delaunay::test::set_missing(grid, 58, 48);
  delaunay::test::set_missing(grid, 59, 47);
  return std::make_shared<const HeightGrid>(std::move(grid));
}

}  // namespace lode::test
