#include "lode/api/terrain_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lode/core/expects.h"
#include "lode/refine/surface_facts.h"

namespace lode {
namespace {

/// More than rounding takes from what is computed in some twenty steps.
constexpr double kRoundingUp = 1 + 0x1p-44;

Result<void> check_terrain_view(const TerrainView& view) {
  if (view.view.width < 1 || view.view.height < 1)
    return fail("view: expected a picture of at least 1 x 1 pixels, got {} x {}", view.view.width,
                view.view.height);
  if (view.max_error_px && !(*view.max_error_px >= 0))
    return fail("max error in pixels: expected a number >= 0, got {}", *view.max_error_px);
  if (!view.max_error_px && !view.has_tolerance)
    return fail("view: expected a tolerance in pixels, or that of the focus, got none");
  return check_camera(view.view.camera);
}

/// Of a triangle and the heights that its error leaves possible in it, as models see it.
Bounds bounds_of(const delaunay::Tin& tin, std::size_t triangle, const HeightFrame& grid,
                 const HeightRange& range) {
  SurfacePatch patch;
  for (const std::uint32_t v : tin.triangles[triangle]) {
    const Vec<double, 2> at = grid.world(tin.vertices[v].x, tin.vertices[v].y);
    patch.add({{at[0], at[1], tin.heights[v]}});
  }
  return patch.bounds(static_cast<double>(tin.errors[triangle]), {range.lower, range.upper});
}

struct ViewDemand {
  TerrainViewFocus focus;
  std::optional<double> max_error_px;
  std::optional<double> tolerance;

  double operator()(const NodeFacts& node) const {
    if (!focus.shows(node.bounds)) return 0;
    double most = tolerance ? node.error - *tolerance : 0;
    if (max_error_px) most = std::max(most, focus.pixels(node.error, node.bounds) - *max_error_px);
    return std::max(most, 0.0);
  }
};

}  // namespace

Result<TerrainViewFocus> TerrainViewFocus::make(const TerrainView& view, const HeightFrame& grid,
                                                const HeightRange& range,
                                                const HorizontalMetric& metric) {
  LODE_CHECK(check_terrain_view(view));
  LODE_TRY(const PictureFrame frame, picture_frame(grid, range, metric, view.exaggeration));
  return TerrainViewFocus(view, frame, range);
}

// Two points A and B = A + d at depths a and b, seen at slopes p and q beside the axis: from
// q b = p a + d' and b = a + d'' (d' beside, d'' along the axis) follows q - p = (d' - p d'') / b.
// With A in the picture p is no larger than its corners, and b at least the depth of the bounds, or
// that of the picture's part of the sphere round the eye that they do not reach into, less |d''|.
TerrainViewFocus::TerrainViewFocus(const TerrainView& view, const PictureFrame& frame,
                                   const HeightRange& range)
    : view_(view), frame_(frame), range_(range), focus_(to_view_focus(view.view)) {
  const Camera& camera = view.view.camera;
  const CameraAxes axes = axes_of(camera);
  const double up = std::tan(camera.field_of_view_deg * std::numbers::pi / 360);
  const double right = up * view.view.width / view.view.height;
  forward_ = axes.forward;
  pixels_per_slope_ = view.view.height / (2 * up);
  sinking_ = std::abs(axes.forward[2]);
  spread_ =
      std::hypot(std::abs(axes.right[2]) + right * sinking_, std::abs(axes.up[2]) + up * sinking_);
  cos_corner_ = 1 / std::hypot(1, right, up);
}

double TerrainViewFocus::pixels(double error, const Bounds& world) const {
  if (error == 0) return 0;
  const Bounds bounds = frame_.place(world);
  const double step = error * frame_.z_scale;
  const double nearest =
      std::max(dot(forward_, bounds.centre - focus_.eye) - bounds.reach(forward_),
               (bounds.beyond(focus_.eye) - bounds.radius) * cos_corner_ - step * sinking_);
  if (!(nearest > 0)) return std::numeric_limits<double>::infinity();
  return pixels_per_slope_ * spread_ * step / nearest * kRoundingUp;
}

Demand TerrainViewFocus::to_demand(double tolerance) const {
  return ViewDemand{*this, view_.max_error_px,
                    view_.has_tolerance ? std::optional(tolerance) : std::nullopt};
}

TerrainViewReport TerrainViewFocus::measure(const delaunay::Tin& tin,
                                            const HeightFrame& grid) const {
  LODE_EXPECTS(tin.errors.size() == tin.triangles.size());
  TerrainViewReport report{.exaggeration = frame_.exaggeration,
                           .is_vertical_unit_known = frame_.is_vertical_unit_known,
                           .max_error_px = view_.max_error_px,
                           .has_tolerance = view_.has_tolerance};
  for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
    const Bounds bounds = bounds_of(tin, t, grid, range_);
    if (!shows(bounds)) continue;
    ++report.n_shown;
    report.achieved_px =
        std::max(report.achieved_px, pixels(static_cast<double>(tin.errors[t]), bounds));
  }
  return report;
}

}  // namespace lode
