#include "lode/core/horizontal_metric.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace lode {

double HorizontalMetric::chords(const Vec<double, 2>& from, const Vec<double, 2>& to,
                                std::size_t n) const {
  std::vector<Vec<double, 2>> places;
  places.reserve(n + 1);
  for (std::size_t i = 0; i <= n; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(n);
    places.push_back(from * (1 - t) + to * t);
  }
  map->apply(places);
  const double turn = elsewhere->ellipsoid ? 2 * std::numbers::pi / elsewhere->angle_unit : 0;
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    // Longitudes may jump from one to the next.
    if (turn > 0) places[i + 1][0] -= turn * std::round((places[i + 1][0] - places[i][0]) / turn);
    sum += elsewhere->distance(places[i], places[i + 1]);
  }
  return sum;
}

// Chords are short of a smooth curve by a share that falls with the square of their number, which
// two numbers of them tell (Richardson's extrapolation), up to a fourth power.
double HorizontalMetric::mapped_distance(const Vec<double, 2>& from,
                                         const Vec<double, 2>& to) const {
  constexpr std::size_t kMostChords = 1024;
  constexpr double kShare = 1e-12;
  constexpr double kOnEarth = 2e7;  // coordinates of the target's plane, whose rounding is noise
  const double noise = elsewhere->ellipsoid ? 0 : 0x1p-51 * kOnEarth;
  double coarse = chords(from, to, 2);
  double last = coarse;
  for (std::size_t n = 4;; n *= 2) {
    const double fine = chords(from, to, n);
    const double length = fine + (fine - coarse) / 3;
    const bool is_good = std::abs(length - last) <= kShare * length + noise;
    if (is_good || n >= kMostChords || !std::isfinite(length)) return length;
    coarse = fine;
    last = length;
  }
}

Result<void> check_angles(const HorizontalMetric& metric, const Vec<double, 2>& lower,
                          const Vec<double, 2>& upper) {
  if (!metric.ellipsoid) return {};
  constexpr double kSlack = 1.01;  // half a pixel of a coarse raster
  const double quarter = std::numbers::pi / 2 / metric.angle_unit * kSlack;
  if (lower[1] >= -quarter && upper[1] <= quarter && upper[0] - lower[0] <= 4 * quarter) return {};
  return fail(
      "expected latitudes from -90 to 90 degrees and longitudes at most 360 apart, got {} to {} "
      "and "
      "{} to {} in the raster's unit of {} radians",
      lower[1], upper[1], lower[0], upper[0], metric.angle_unit);
}

}  // namespace lode
