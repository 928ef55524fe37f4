#include "lode/core/horizontal_metric.h"

#include <numbers>

namespace lode {

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
