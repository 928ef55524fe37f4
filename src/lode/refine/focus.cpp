#include "lode/refine/focus.h"

#include <algorithm>
#include <cmath>

namespace lode {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();
/// Wants refining, but after everything that has an error.
constexpr double kLast = 1e-30;

bool touches_focus(const IsovalueFocus& focus, const NodeFacts& node) {
  return std::any_of(focus.isovalues.begin(), focus.isovalues.end(),
                     [&](double isovalue) { return node.range.crosses(isovalue); });
}

bool touches_focus(const IntervalFocus& focus, const NodeFacts& node) {
  return !node.range.is_empty() &&
         std::any_of(focus.intervals.begin(), focus.intervals.end(),
                     [&](const Range& interval) { return node.range.meets(interval); });
}

bool touches_focus(const BoxFocus& focus, const NodeFacts& node) {
  double squared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double lower = node.bounds.centre[i] - node.bounds.half[i];
    const double upper = node.bounds.centre[i] + node.bounds.half[i];
    const double d = std::max({focus.box.lower[i] - upper, lower - focus.box.upper[i], 0.0});
    squared += d * d;
  }
  return squared <= node.bounds.radius * node.bounds.radius;
}

bool touches_focus(const BallFocus& focus, const NodeFacts& node) {
  return node.bounds.beyond(focus.ball.centre) <= node.bounds.radius + focus.ball.radius;
}

bool touches_focus(const HalfSpaceFocus& focus, const NodeFacts& node) {
  const Vec3d normal = normalized(focus.normal);
  return dot(node.bounds.centre - focus.point, normal) >= -node.bounds.reach(normal);
}

bool touches_focus(const SectionFocus& focus, const NodeFacts& node) {
  const Vec3d normal = normalized(focus.normal);
  return std::abs(dot(node.bounds.centre - focus.point, normal)) <= node.bounds.reach(normal);
}

double opacity_at(const OpacityFocus& focus, double value) {
  const auto& points = focus.points;
  const auto above = std::find_if(points.begin(), points.end(),
                                  [&](const auto& point) { return point.value >= value; });
  if (above == points.end()) return points.back().opacity;
  if (above == points.begin()) return above->opacity;
  const auto& below = *(above - 1);
  const double t = (value - below.value) / (above->value - below.value);
  return below.opacity + t * (above->opacity - below.opacity);
}

bool touches_focus(const OpacityFocus& focus, const NodeFacts& node) {
  if (focus.points.empty() || node.range.is_empty()) return false;
  if (opacity_at(focus, node.range.low) > 0 || opacity_at(focus, node.range.high) > 0) return true;
  return std::any_of(focus.points.begin(), focus.points.end(), [&](const auto& point) {
    return point.opacity > 0 && node.range.low <= point.value && point.value <= node.range.high;
  });
}

/// The largest opacity of the range's values, as a share of all there is; 1 of what is none.
double weight_of(const Focus& focus, const NodeFacts& node) {
  const auto* opacity = std::get_if<OpacityFocus>(&focus);
  if (opacity == nullptr || opacity->points.empty() || node.range.is_empty()) return 1;
  double all = 0;
  double most =
      std::max(opacity_at(*opacity, node.range.low), opacity_at(*opacity, node.range.high));
  for (const auto& point : opacity->points) {
    all = std::max(all, point.opacity);
    if (node.range.low <= point.value && point.value <= node.range.high)
      most = std::max(most, point.opacity);
  }
  return all > 0 ? most / all : 0;
}

bool touches_focus(const ViewFocus& focus, const NodeFacts& node) {
  return focus.shows(node.bounds);
}

double excess(double error, double tolerance) {
  if (tolerance == 0) return std::max(error, kLast);
  return std::max(0.0, error - tolerance);
}

}  // namespace

bool ViewFocus::shows(const Bounds& bounds) const {
  return std::all_of(planes.begin(), planes.end(), [&](const Plane& plane) {
    return dot(plane.normal, bounds.centre) - plane.offset <= bounds.reach(plane.normal);
  });
}

double ViewFocus::pixels(double length_of, const Bounds& bounds) const {
  if (length_of == 0) return 0;
  const double distance = bounds.beyond(eye) - bounds.radius;
  return distance > 0 ? pixels_per_radian * length_of / distance : kEndless;
}

bool touches(const Focus& focus, const NodeFacts& node) {
  return std::visit([&](const auto& kind) { return touches_focus(kind, node); }, focus);
}

double FocusDemand::measure(const NodeFacts& node) const {
  switch (unit) {
    case ErrorUnit::field: return node.error;
    case ErrorUnit::world: return node.world_error;
    case ErrorUnit::pixels: return view ? view->pixels(node.world_error, node.bounds) : 0;
  }
  return node.error;
}

double FocusDemand::error(const NodeFacts& node) const {
  const bool is_inside = std::all_of(
      foci.begin(), foci.end(), [&](const Focus& focus) { return lode::touches(focus, node); });
  return is_inside ? measure(node) : 0;
}

double FocusDemand::operator()(const NodeFacts& node) const { return evaluate(node).demand; }
bool FocusDemand::touches(const NodeFacts& node) const { return evaluate(node).touches; }

Evaluation FocusDemand::evaluate(const NodeFacts& node) const {
  Evaluation result;
  bool is_inside = true;
  double weight = 1;
  for (const Focus& focus : foci) {
    weight *= weight_of(focus, node);
    if (lode::touches(focus, node)) continue;
    is_inside = false;
    // A view does not count: what is out of sight remains a candidate, so that a moved view finds
    // it.
    result.touches = std::holds_alternative<ViewFocus>(focus);
    if (!result.touches) break;
  }
  if (outside != kEndless) {
    result.touches = true;
    // Inside, too: it would not be monotone otherwise.
    result.demand = excess(measure(node), outside);
  }
  if (is_inside && inside != kEndless)
    result.demand = std::max(result.demand, excess(weight * measure(node), inside));
  if (is_inside && ends_at_border && node.is_at_border)
    result.demand = std::max(result.demand, kLast);
  return result;
}

bool FocusDemand::uses_bounds() const {
  if (unit == ErrorUnit::pixels) return true;
  return std::any_of(foci.begin(), foci.end(), [](const Focus& focus) {
    return !std::holds_alternative<IsovalueFocus>(focus) &&
           !std::holds_alternative<IntervalFocus>(focus) &&
           !std::holds_alternative<OpacityFocus>(focus);
  });
}

Demand uniform_demand(double tolerance) {
  FocusDemand demand;
  demand.inside = tolerance;
  return demand;
}

Demand isovalue_demand(double isovalue, double tolerance) {
  FocusDemand demand;
  demand.foci = {IsovalueFocus{{isovalue}}};
  demand.inside = tolerance;
  demand.ends_at_border = true;
  return demand;
}

}  // namespace lode
