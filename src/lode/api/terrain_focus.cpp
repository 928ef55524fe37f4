#include "lode/api/terrain_focus.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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

}  // namespace

Result<TerrainDemand> TerrainDemand::make(const TerrainFocus& focus, double tolerance,
                                          const HeightFrame& grid, const HeightRange& range) {
  LODE_CHECK(check_focus(focus));
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
