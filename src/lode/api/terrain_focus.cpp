#include "lode/api/terrain_focus.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "lode/api/round_terrain.h"
#include "lode/refine/focus.h"
#include "lode/refine/surface_facts.h"

namespace lode {
namespace {

constexpr double kAllHeights = std::numeric_limits<double>::max();

/// Refines what errs by more than the tolerance and `growth` for each unit of distance.
struct GrowingDemand {
  Vec<double, 2> point;
  double tolerance = 0;
  double growth = 0;
  HorizontalMetric metric;

  double operator()(const NodeFacts& node) const {
    Vec<double, 2> nearest;
    for (std::size_t i = 0; i < 2; ++i)
      nearest[i] = std::clamp(point[i], node.bounds.centre[i] - node.bounds.half[i],
                              node.bounds.centre[i] + node.bounds.half[i]);
    const double allowed =
        tolerance + (growth > 0 ? growth * metric.distance(point, nearest) : 0.0);
    return node.error - allowed;
  }
};

FocusDemand demand_in(const PlaceBox& box, double tolerance) {
  FocusDemand demand;
  demand.foci.emplace_back(BoxFocus{
      {{{box.lower[0], box.lower[1], -kAllHeights}}, {{box.upper[0], box.upper[1], kAllHeights}}}});
  demand.inside = tolerance;
  return demand;
}

/// Of all of a terrain, as if nothing were known of it.
NodeFacts worst_facts(const HeightFrame& grid, const HeightRange& range) {
  SurfacePatch patch;
  for (const double x : {0, grid.n_columns - 1})
    for (const double y : {0, grid.n_rows - 1}) {
      const Vec<double, 2> at = grid.world(x, y);
      patch.add({{at[0], at[1], range.lower}});
    }
  return patch.facts(kAllHeights, {range.lower, range.upper});
}

Result<void> check_focus(const TerrainFocus& focus) {
  if (focus.is_empty()) return fail("focus: expected a box, a point or a view, got none");
  for (const PlaceBox& box : focus.boxes)
    for (std::size_t i = 0; i < 2; ++i)
      if (!(box.lower[i] <= box.upper[i]) || !std::isfinite(box.upper[i] - box.lower[i]))
        return fail("focus: expected a box from lower to upper, got {} to {}", box.lower[i],
                    box.upper[i]);
  if (focus.point && !(std::isfinite((*focus.point)[0]) && std::isfinite((*focus.point)[1])))
    return fail("focus: expected a finite place, got {}, {}", (*focus.point)[0], (*focus.point)[1]);
  if (!(focus.growth >= 0 && std::isfinite(focus.growth)))
    return fail("focus: expected a growth >= 0, got {}", focus.growth);
  if (focus.max_error_outside && !(*focus.max_error_outside >= 0))
    return fail("focus: expected a tolerance >= 0 outside, got {}", *focus.max_error_outside);
  return {};
}

using Ring = std::vector<Vec<double, 2>>;

double area_of(const Ring& ring) {
  double doubled = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    // From one of its own, as places may be far from the origin.
    const Vec<double, 2> a = ring[i] - ring[0];
    const Vec<double, 2> b = ring[(i + 1) % ring.size()] - ring[0];
    doubled += a[0] * b[1] - a[1] * b[0];
  }
  return std::abs(doubled) / 2;
}

/// What of a convex ring is on the side of a coordinate where `sign` times it is larger.
Ring cut(const Ring& ring, std::size_t axis, double limit, double sign) {
  Ring left;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec<double, 2>& a = ring[i];
    const Vec<double, 2>& b = ring[(i + 1) % ring.size()];
    const double depth = sign * (a[axis] - limit);
    const double next = sign * (b[axis] - limit);
    if (depth >= 0) left.push_back(a);
    if ((depth < 0) != (next < 0)) left.push_back(a + (b - a) * (depth / (depth - next)));
  }
  return left;
}

/// With places that may be whole turns away.
TerrainFocus focus_near(TerrainFocus focus, const HeightFrame& frame) {
  for (PlaceBox& box : focus.boxes) box = near_terrain(box, focus.metric, frame);
  if (focus.point)
    (*focus.point)[0] += turns_towards(focus.metric, middle_x(frame), (*focus.point)[0]);
  return focus;
}

}  // namespace

PlaceBox near_terrain(const PlaceBox& box, const HorizontalMetric& metric,
                      const HeightFrame& frame) {
  PlaceBox near = box;
  const double turn =
      metric.ellipsoid ? whole_turn(metric) : std::numeric_limits<double>::infinity();
  if (box.upper[0] - box.lower[0] >= turn) {  // all longitudes
    near.lower[0] = std::min(box.lower[0], middle_x(frame) - turn);
    near.upper[0] = std::max(box.upper[0], middle_x(frame) + turn);
    return near;
  }
  const double middle = (box.lower[0] + box.upper[0]) / 2;
  const double shift = turns_towards(metric, middle_x(frame), middle);
  near.lower[0] += shift;
  near.upper[0] += shift;
  return near;
}

double share_outside(const PlaceBox& box, const HeightFrame& frame) {
  // Lines and points get some width; shares of areas are the same in columns and rows.
  constexpr double kThin = 1e-6;
  const Vec<double, 2> a = frame.world(0, 0);
  const Vec<double, 2> b = frame.world(1, 1);
  const double pad = kThin * std::max(std::abs(b[0] - a[0]), std::abs(b[1] - a[1]));
  const Vec<double, 2> lower = box.lower - Vec<double, 2>{{pad, pad}};
  const Vec<double, 2> upper = box.upper + Vec<double, 2>{{pad, pad}};
  Ring ring;
  for (const auto& [x, y] : {std::pair{lower[0], lower[1]},
                             {upper[0], lower[1]},
                             {upper[0], upper[1]},
                             {lower[0], upper[1]}})
    ring.push_back(frame.lattice(x, y));
  const double all = area_of(ring);
  const std::array<double, 2> last{frame.n_columns - 0.5, frame.n_rows - 0.5};
  for (std::size_t axis = 0; axis < 2 && !ring.empty(); ++axis)
    ring = cut(cut(ring, axis, -0.5 - kThin, 1), axis, last[axis] + kThin, -1);
  return std::clamp(1 - (ring.empty() ? 0 : area_of(ring)) / all, 0.0, 1.0);
}

Result<TerrainDemand> TerrainDemand::make(const TerrainFocus& wanted, double tolerance,
                                          const HeightFrame& grid, const HeightRange& range) {
  LODE_CHECK(check_focus(wanted));
  const TerrainFocus focus = focus_near(wanted, grid);
  TerrainDemand made;
  std::vector<Demand> demands;
  for (const PlaceBox& box : focus.boxes) demands.emplace_back(demand_in(box, tolerance));
  if (focus.point)
    demands.emplace_back(GrowingDemand{*focus.point, tolerance, focus.growth, focus.metric});
  if (focus.view) {
    LODE_TRY(made.view_, TerrainViewFocus::make(*focus.view, grid, range, focus.metric));
    demands.push_back(made.view_->to_demand(tolerance));
  }
  made.meets_terrain_ = max_of(demands)(worst_facts(grid, range)) > 0;
  if (focus.max_error_outside) demands.push_back(uniform_demand(*focus.max_error_outside));
  made.demand_ = max_of(std::move(demands));
  return made;
}

std::optional<TerrainViewReport> TerrainDemand::measure(const delaunay::Tin& tin,
                                                        const HeightFrame& grid) const {
  if (!view_) return {};
  return view_->measure(tin, grid);
}

}  // namespace lode
