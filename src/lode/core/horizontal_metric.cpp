#include "lode/core/horizontal_metric.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace lode {
namespace {

/// A chord is no longer than those beside it by more than this, and rounding, unless the map jumps
/// there.
constexpr double kMostUneven = 1.25;
constexpr double kMillimetre = 1e-3;

}  // namespace

Chords HorizontalMetric::chords(const Vec<double, 2>& from, const Vec<double, 2>& to,
                                std::size_t n) const {
  std::vector<Vec<double, 2>> places;
  places.reserve(n + 1);
  for (std::size_t i = 0; i <= n; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(n);
    places.push_back(from * (1 - t) + to * t);
  }
  map->apply(places);
  const double turn = elsewhere->ellipsoid ? 2 * std::numbers::pi / elsewhere->angle_unit : 0;
  std::vector<double> lengths;
  lengths.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    // Longitudes may jump from one to the next.
    if (turn > 0) places[i + 1][0] -= turn * std::round((places[i + 1][0] - places[i][0]) / turn);
    lengths.push_back(elsewhere->distance(places[i], places[i + 1]));
  }
  const double rounding = kMillimetre / elsewhere->metres();
  Chords made;
  for (std::size_t i = 0; i < n; ++i) {
    const double beside = std::max(i > 0 ? lengths[i - 1] : 0, i + 1 < n ? lengths[i + 1] : 0);
    made.is_even = made.is_even && lengths[i] <= kMostUneven * beside + rounding;
    made.length += lengths[i];
  }
  return made;
}

// Chords are short of a smooth curve by a share that falls with the square of their number, which
// two numbers of them tell (Richardson's extrapolation), up to a fourth power.
double HorizontalMetric::mapped_distance(const Vec<double, 2>& from,
                                         const Vec<double, 2>& to) const {
  constexpr std::size_t kMostChords = 1024;
  constexpr double kShare = 1e-12;
  constexpr double kOnEarth = 2e7;  // coordinates of the target's plane, whose rounding is noise
  const double noise = elsewhere->ellipsoid ? 0 : 0x1p-51 * kOnEarth;
  constexpr double kRoughly = 1e-6;  // of lengths that rounding in the map keeps from agreeing
  double coarse = chords(from, to, 2).length;
  double last = coarse;
  for (std::size_t n = 4;; n *= 2) {
    const Chords fine = chords(from, to, n);
    const double length = fine.length + (fine.length - coarse) / 3;
    const double change = std::abs(length - last);
    if (!std::isfinite(length)) return length;
    if (fine.is_even && change <= kShare * length + noise) return length;
    if (n >= kMostChords)
      return fine.is_even && change <= kRoughly * length + kMillimetre / elsewhere->metres()
                 ? length
                 : std::numeric_limits<double>::quiet_NaN();
    coarse = fine.length;
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
