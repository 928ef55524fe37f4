// Where the vertex that an edge becomes may lie.
#include <algorithm>
#include <cmath>
#include <limits>

#include "lode/models/tetra_mt/midpoint/edge_collapser.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// How far from the faces' planes a vertex may be that goes along them, against its distance.
constexpr double kCoplanar = 1e-6;
/// What comparing sheets in one plane may be off by, against the edge's length.
constexpr double kNoise = 0x1p-40;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace

/// By field 1 where all beside a vertex have lower values, -1 where all have higher ones.
void EdgeCollapser::find_extrema(const Star& star, std::vector<int>& found) const {
  const std::size_t n = state_.n_fields;
  found.resize(n);
  for (std::size_t f = 0; f < n; ++f) {
    const double own = values_[star.vertex * n + f];
    bool has_lower = false;
    bool has_higher = false;
    for (int i = 0; i < star.n_link; ++i) {
      if (i == star.outside) continue;
      const double value = values_[star.link[static_cast<std::size_t>(i)] * n + f];
      has_lower = has_lower || value <= own;
      has_higher = has_higher || value >= own;
    }
    found[f] = has_higher ? (has_lower ? 0 : -1) : 1;
  }
}

/// Of each field the value of the end that is an extremum, or that which lies there. False where
/// one end is a maximum of a field, and the other a minimum.
bool EdgeCollapser::find_value_places(Place position) {
  for (std::size_t f = 0; f < state_.n_fields; ++f)
    if (extrema_[f] * other_extrema_[f] < 0) return false;
  take_value_places(position);
  return true;
}
/// Likewise, also where the ends are a maximum and a minimum: of two extrema neither is more.
void EdgeCollapser::take_value_places(Place position) {
  for (std::size_t f = 0; f < state_.n_fields; ++f) {
    const bool is_either = extrema_[f] * other_extrema_[f] < 0;
    value_[f].place = is_either                ? position
                      : extrema_[f] != 0       ? Place::first
                      : other_extrema_[f] != 0 ? Place::second
                                               : position;
  }
}

void EdgeCollapser::find_interfaces_of(const Star& star, Interfaces& found) const {
  if (state_.labels.empty()) {
    find_boundary(star, found);
    return;
  }
  std::array<std::uint32_t, Star::kMaxTriangles> labels;
  const auto n = static_cast<std::size_t>(star.n_triangles);
  for (std::size_t i = 0; i < n; ++i) labels[i] = state_.labels[slots_[star.slots[i]]];
  find_interfaces(star, std::span(labels).first(n), found);
}

/// How far out of its faces' planes a vertex goes with its edge, 0 where it has no such faces;
/// infinite where they do not let it.
double EdgeCollapser::height(const Star& star, const Interfaces& interfaces, int kept) const {
  if (!goes_along(interfaces, kept)) return kInfinite;
  const auto way_to = [&](int place) {
    const auto at = static_cast<std::size_t>(place);
    return (positions_[star.link[at]] - positions_[star.vertex]) * scale_;
  };
  const Vec3d at = way_to(kept);
  const double limit = std::max(kCoplanar * length(at), state_.step_limit * scale_);
  double largest = outline_height(star, interfaces, kept, way_to);
  if (!(largest <= limit)) return kInfinite;
  for (int i = 0; i < interfaces.n_faces; ++i) {
    const auto& edge = interfaces.faces[static_cast<std::size_t>(i)].edge;
    if (edge[0] == kept || edge[1] == kept) continue;
    if (edge[0] == star.outside || edge[1] == star.outside) continue;
    const Vec3d normal = cross(way_to(edge[0]), way_to(edge[1]));
    const double volume = std::abs(dot(normal, at));
    if (volume == 0) continue;
    const double out = volume / length(normal);
    if (!(out <= limit)) return kInfinite;
    largest = std::max(largest, out);
  }
  return largest / scale_;
}

/// How far the faces round a vertex may be off already.
double EdgeCollapser::deviation(const Star& star, const Interfaces& interfaces) const {
  double largest = 0;
  if (interfaces.kind == Interfaces::Kind::none) return largest;
  for (int i = 0; i < star.n_triangles; ++i)
    largest = std::max(largest, state_.deviations[slots_[star.slots[static_cast<std::size_t>(i)]]]);
  return largest;
}

/// In the middle where both ends may go along the edge in their planes; else where the one is that
/// may not. Sheets are compared even there, as where they bend: both sides of a flap without volume
/// lie in one plane, too, but its outline would move.
std::optional<EdgeCollapser::Rule> EdgeCollapser::flat_rule_of(int place, double limit) {
  const double first = height(star_, interfaces_, place);
  const double second = height(other_, other_interfaces_, place_in_other_);
  if (std::min(first, second) == kInfinite) return {};
  Rule rule{Place::middle, std::max(first, second)};
  if (rule.moved == kInfinite)
    rule = {second == kInfinite ? Place::second : Place::first, std::min(first, second)};
  const bool is_first_alone = rule.position == Place::second;
  const Interfaces& moving = is_first_alone ? interfaces_ : other_interfaces_;
  if (moving.kind != Interfaces::Kind::sheet) return rule;
  const double off = rule.position == Place::middle ? deviation_of_middle(place, limit)
                     : is_first_alone
                         ? deviation_of_end(star_, interfaces_, place, limit)
                         : deviation_of_end(other_, other_interfaces_, place_in_other_, limit);
  const Vec3d edge =
      positions_[star_.link[static_cast<std::size_t>(place)]] - positions_[star_.vertex];
  // In a plane exactly nothing moves but by rounding of the comparison.
  if (rule.moved > 0 || !(off <= kNoise * length(edge))) rule.moved = off;
  return rule;
}

/// Flat where that is possible, as nothing moves then.
std::optional<EdgeCollapser::Rule> EdgeCollapser::place_rule_of(int place) {
  const double before =
      std::max(deviation(star_, interfaces_), deviation(other_, other_interfaces_));
  const double limit = state_.deviation_limit - before;
  auto rule = flat_rule_of(place, limit);
  if ((!rule || !(rule->moved <= limit)) && state_.boundary_tolerance > 0)
    rule = bent_rule_of(place, limit);
  if (!rule || !(rule->moved <= limit)) return {};
  rule->moved += before;
  return rule;
}

/// With the places of values.
std::optional<EdgeCollapser::Rule> EdgeCollapser::rule_of(int place) {
  const auto rule = place_rule_of(place);
  return rule && find_value_places(rule->position) ? rule : std::nullopt;
}

/// Expects the link condition of the mesh.
bool EdgeCollapser::keeps_regions(int place) const {
  if (state_.labels.empty()) return true;
  return rule_.position == Place::first
             ? keeps_interfaces(other_, other_interfaces_, place_in_other_, star_, interfaces_)
             : keeps_interfaces(star_, interfaces_, place, other_, other_interfaces_);
}

}  // namespace lode::tetra_mt::midpoint
