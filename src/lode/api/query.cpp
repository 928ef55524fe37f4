#include "lode/api/query.h"

#include <cmath>
#include <numbers>
#include <tuple>

namespace lode {
namespace {

bool is_finite(const Vec3d& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

Result<void> check_tolerance(const char* name, const std::optional<double>& tolerance) {
  if (tolerance && !(*tolerance >= 0))
    return fail("{}: expected a number >= 0, got {}", name, *tolerance);
  return {};
}

Result<void> check_values(const Query& query) {
  for (const double isovalue : query.isovalues)
    if (!std::isfinite(isovalue))
      return fail("isovalue: expected a finite number, got {}", isovalue);
  for (const Range& range : query.field_ranges)
    if (!(range.low <= range.high))
      return fail("field range: expected A <= B, got {} and {}", range.low, range.high);
  for (std::size_t i = 0; i < query.opacity.size(); ++i) {
    const auto& point = query.opacity[i];
    if (!std::isfinite(point.value) || !(point.opacity >= 0))
      return fail("opacity: expected finite values and opacities >= 0, got {} at {}", point.opacity,
                  point.value);
    if (i > 0 && !(query.opacity[i - 1].value < point.value))
      return fail("opacity: expected ascending values, got {} after {}", point.value,
                  query.opacity[i - 1].value);
  }
  return {};
}

Result<void> check_plane(const char* name, const Vec3d& point, const Vec3d& normal) {
  if (!is_finite(point) || !(length(normal) > 0) || !std::isfinite(length(normal)))
    return fail("{}: expected a finite point and a normal that is not zero", name);
  return {};
}

Result<void> check_regions(const Query& query) {
  for (const Box3d& box : query.boxes)
    for (std::size_t i = 0; i < 3; ++i)
      if (!(box.lower[i] <= box.upper[i]))
        return fail("box: expected lower <= upper, got {} and {}", box.lower[i], box.upper[i]);
  for (const Ball& ball : query.balls)
    if (!is_finite(ball.centre) || !(ball.radius >= 0))
      return fail("ball: expected a finite centre and a radius >= 0, got {}", ball.radius);
  for (const HalfSpaceFocus& space : query.half_spaces)
    LODE_CHECK(check_plane("half-space", space.point, space.normal));
  for (const SectionFocus& section : query.sections)
    LODE_CHECK(check_plane("section", section.point, section.normal));
  return {};
}

/// Which values matter, one focus a kind.
std::vector<Focus> value_foci(const Query& query) {
  std::vector<Focus> foci;
  if (!query.isovalues.empty()) foci.emplace_back(IsovalueFocus{query.isovalues});
  if (!query.field_ranges.empty()) foci.emplace_back(IntervalFocus{query.field_ranges});
  if (!query.opacity.empty()) foci.emplace_back(OpacityFocus{query.opacity});
  return foci;
}

std::vector<Focus> region_foci(const Query& query) {
  std::vector<Focus> foci;
  for (const Box3d& box : query.boxes) foci.emplace_back(BoxFocus{box});
  for (const Ball& ball : query.balls) foci.emplace_back(BallFocus{ball});
  foci.insert(foci.end(), query.half_spaces.begin(), query.half_spaces.end());
  foci.insert(foci.end(), query.sections.begin(), query.sections.end());
  return foci;
}

/// One demand for each value and region, and one for each value outside the regions.
std::vector<FocusDemand> parts_of(const Query& query, ErrorUnit unit, double tolerance) {
  FocusDemand everywhere;
  everywhere.inside = tolerance;
  everywhere.unit = unit;
  everywhere.ends_at_border = !query.isovalues.empty();
  if (query.view) everywhere.view = to_view_focus(*query.view);
  std::vector<FocusDemand> by_value;
  for (const Focus& value : value_foci(query)) {
    by_value.push_back(everywhere);
    by_value.back().foci.push_back(value);
  }
  if (by_value.empty()) by_value.push_back(everywhere);

  const std::vector<Focus> regions = region_foci(query);
  std::vector<FocusDemand> parts;
  for (const FocusDemand& value : by_value) {
    for (std::size_t i = 0; i < std::max<std::size_t>(1, regions.size()); ++i) {
      FocusDemand& part = parts.emplace_back(value);
      if (!regions.empty()) part.foci.push_back(regions[i]);
      if (query.view) part.foci.emplace_back(*part.view);
    }
    if (query.max_error_outside && (query.view || !regions.empty())) {
      FocusDemand& outside = parts.emplace_back(value);
      outside.inside = *query.max_error_outside;
    }
  }
  return parts;
}

}  // namespace

Result<void> check_query(const Query& query) {
  LODE_CHECK(check_values(query));
  LODE_CHECK(check_regions(query));
  LODE_CHECK(check_tolerance("max error", query.max_error));
  LODE_CHECK(check_tolerance("max error in pixels", query.max_error_px));
  LODE_CHECK(check_tolerance("max world error", query.max_world_error));
  LODE_CHECK(check_tolerance("max error outside", query.max_error_outside));
  if (!query.max_error && !query.max_error_px && !query.max_world_error)
    return fail("expected a tolerance, got none");
  if (query.max_error_px && !query.view)
    return fail("max error in pixels: expected a view that says how large pixels are");
  if (!query.view) return {};
  if (query.view->width < 1 || query.view->height < 1)
    return fail("view: expected a picture of at least 1 x 1 pixels, got {} x {}", query.view->width,
                query.view->height);
  return check_camera(query.view->camera);
}

Demand to_demand(const Query& query) {
  std::vector<FocusDemand> parts;
  const auto add = [&](ErrorUnit unit, double tolerance) {
    for (FocusDemand& part : parts_of(query, unit, tolerance)) parts.push_back(std::move(part));
  };
  if (query.max_error) add(ErrorUnit::field, *query.max_error);
  if (query.max_world_error) add(ErrorUnit::world, *query.max_world_error);
  if (query.max_error_px) add(ErrorUnit::pixels, *query.max_error_px);
  if (parts.size() == 1) return std::move(parts.front());
  return max_of({parts.begin(), parts.end()});
}

std::vector<FocusDemand> pixel_measures(const Query& query) {
  return query.view ? parts_of(query, ErrorUnit::pixels, 0) : std::vector<FocusDemand>{};
}

FocusChange focus_change(const Query& a, const Query& b) {
  const auto focus = [](const Query& query) {
    return std::tie(query.isovalues, query.field_ranges, query.opacity, query.boxes, query.balls,
                    query.half_spaces, query.sections);
  };
  const bool is_same = focus(a) == focus(b) && a.view.has_value() == b.view.has_value() &&
                       a.max_error_outside.has_value() == b.max_error_outside.has_value();
  return is_same ? FocusChange::same : FocusChange::changed;
}

ViewFocus to_view_focus(const View& view) {
  const Camera& camera = view.camera;
  const CameraAxes axes = axes_of(camera);
  const double angle = camera.field_of_view_deg * std::numbers::pi / 180;
  const double up = std::tan(angle / 2);
  const double right = up * view.width / view.height;
  ViewFocus focus;
  focus.eye = camera.eye;
  focus.pixels_per_radian = view.height / angle;
  const auto side = [&](const Vec3d& outward) {
    return ViewFocus::Plane{outward, dot(outward, camera.eye)};
  };
  focus.planes = {side(normalized(axes.right - axes.forward * right)),
                  side(normalized(axes.right * -1.0 - axes.forward * right)),
                  side(normalized(axes.up - axes.forward * up)),
                  side(normalized(axes.up * -1.0 - axes.forward * up)), side(axes.forward * -1.0)};
  return focus;
}

}  // namespace lode
