#include "lode/api/picture_frame.h"

#include <array>
#include <cmath>
#include <numbers>

#include "lode/core/vertical_unit.h"

namespace lode {
namespace {

constexpr double kReliefShare = 0.125;
constexpr double kMostExaggeration = 1e6;

/// Of the ellipsoid at the middle, but not nearer to the poles than 85 degrees.
void take_metric(const HorizontalMetric& metric, PictureFrame& frame) {
  frame.x_scale = frame.y_scale = metric.metres();
  if (!metric.ellipsoid) return;
  constexpr double kStep = 1e-4;
  const double most = 85 * std::numbers::pi / 180 / metric.angle_unit;
  const double latitude = std::clamp(frame.middle[1], -most, most);
  frame.x_scale = metric.distance({{0, latitude}}, {{kStep, latitude}}) / kStep;
  frame.y_scale = metric.distance({{0, latitude}}, {{0, latitude + kStep}}) / kStep;
}

/// The largest of 1, 2, 5, 10, ... that is no more.
double nice_below(double most) {
  if (!(most > 1)) return 1;
  const double power = std::pow(10, std::floor(std::log10(most)));
  for (const double step : {5.0, 2.0})
    if (step * power <= most) return step * power;
  return power;
}

/// Round the raster, in its coordinates.
struct Extent {
  Vec<double, 2> lower;
  Vec<double, 2> upper;
};

Extent extent_of(const HeightFrame& grid) {
  const double columns = grid.n_columns - 1;
  const double rows = grid.n_rows - 1;
  const std::array corners{grid.world(0, 0), grid.world(columns, 0), grid.world(0, rows),
                           grid.world(columns, rows)};
  Extent extent{corners[0], corners[0]};
  for (const auto& corner : corners)
    for (std::size_t i = 0; i < 2; ++i) {
      extent.lower[i] = std::min(extent.lower[i], corner[i]);
      extent.upper[i] = std::max(extent.upper[i], corner[i]);
    }
  return extent;
}

}  // namespace

Bounds PictureFrame::place(const Bounds& world) const {
  const Vec3d& c = world.centre;
  return {.centre = place({{c[0], c[1]}}, c[2]),
          .radius = world.radius * std::max({x_scale, y_scale, z_scale}),
          .half = {{world.half[0] * x_scale, world.half[1] * y_scale, world.half[2] * z_scale}}};
}

Result<PictureFrame> picture_frame(const HeightFrame& grid, const HeightRange& range,
                                   const HorizontalMetric& metric,
                                   const std::optional<double>& exaggeration) {
  if (exaggeration &&
      !(*exaggeration >= 1 / kMostExaggeration && *exaggeration <= kMostExaggeration))
    return fail("exaggeration: expected a number from {} to {}, got {}", 1 / kMostExaggeration,
                kMostExaggeration, *exaggeration);
  const auto [lower, upper] = extent_of(grid);
  LODE_CHECK(check_angles(metric, lower, upper));
  PictureFrame frame;
  frame.middle = (lower + upper) * 0.5;
  take_metric(metric, frame);
  frame.half = {
      {(upper[0] - lower[0]) * frame.x_scale / 2, (upper[1] - lower[1]) * frame.y_scale / 2}};
  const std::optional<double> unit = metres_of_unit(grid.vertical_unit);
  frame.is_vertical_unit_known = unit.has_value();
  const double metres = unit.value_or(metric.assumed_height_unit());
  const double relief = (range.upper - range.lower) * metres;
  frame.exaggeration = exaggeration.value_or(
      relief > 0 ? nice_below(kReliefShare * frame.longer_side() / relief) : 1);
  frame.z_scale = metres * frame.exaggeration;
  frame.z_middle = (range.lower + range.upper) / 2;
  return frame;
}

}  // namespace lode
