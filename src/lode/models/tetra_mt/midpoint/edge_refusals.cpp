// Why vertices stay.
#include <algorithm>
#include <limits>

#include "lode/models/tetra_mt/midpoint/edge_collapser.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// How many rules an edge has passed: it is known where the vertex comes before its values are.
int n_passed(Refusal refusal) {
  switch (refusal) {
    case Refusal::boundary:
    case Refusal::regions: return static_cast<int>(refusal) - 1;
    case Refusal::extremum: return static_cast<int>(Refusal::regions);
    default: return static_cast<int>(refusal);
  }
}

}  // namespace

/// Each edge is looked at from one end, as the build does: no more of them than say something new.
RefusalCounts EdgeCollapser::count_refusals() {
  std::vector<Refusal> farthest(live_.n_own(), Refusal::non_manifold);
  const auto pass = [&](std::uint32_t vertex, Refusal refusal) {
    farthest[vertex] = std::max(farthest[vertex], refusal,
                                [](Refusal a, Refusal b) { return n_passed(a) < n_passed(b); });
  };
  RefusalCounts counts;
  for (std::uint32_t v = 0; v < live_.n_own(); ++v) {
    if (live_.star(v).empty()) continue;
    if (const auto own = refusal_of_link(v)) {
      farthest[v] = *own;
    } else {
      look_at_star();
      if (is_by_quadrics()) gather_own_samples();
      for (int place = 0; place < star_.n_link; ++place) {
        const std::uint32_t other = star_.link[static_cast<std::size_t>(place)];
        if (place == star_.outside || !owns_edge_to(other)) continue;
        if (std::min(farthest[v], farthest[other]) == Refusal::limit) continue;
        const EdgeRefusal refusal = refusal_of_edge(place);
        pass(v, refusal.first);
        pass(other, refusal.second);
      }
    }
    // Those with smaller slots, whose edges to it these are, were looked at before.
    counts.add(farthest[v]);
  }
  return counts;
}

/// Of a vertex that no edge may have: expects nothing, and leaves its star.
std::optional<Refusal> EdgeCollapser::refusal_of_link(std::uint32_t vertex) {
  if (!gatherer_.gather(vertex, star_)) return Refusal::crowded;
  if (!StarGatherer::is_manifold(star_)) return Refusal::non_manifold;
  // Its link was too large at first.
  return state_.is_locked[global(vertex)] != 0 ? std::optional(Refusal::crowded) : std::nullopt;
}

/// Expects the star of one end, and that neither is locked.
EdgeCollapser::EdgeRefusal EdgeCollapser::refusal_of_edge(int place) {
  const auto of_both = [](Refusal refusal) { return EdgeRefusal{refusal, refusal}; };
  if (!look_at_one_edge(place)) return of_both(Refusal::crowded);
  const auto rule = place_rule_of(place);
  if (!rule)
    return {refusal_to_move(star_, interfaces_), refusal_to_move(other_, other_interfaces_)};
  if (!find_value_places(rule->position)) return of_both(Refusal::extremum);
  rule_ = *rule;
  if (!make_fan_at(place)) return of_both(Refusal::shape);
  if (!gatherer_.may_collapse(star_, place, std::numeric_limits<int>::max()) ||
      !keeps_regions(place))
    return of_both(Refusal::topology);
  if (!gatherer_.may_collapse(star_, place, kMaxLink)) return of_both(Refusal::crowded);
  return of_both(cover_samples() ? Refusal::limit : Refusal::rounding);
}

/// Of an end that may not go along the edge.
Refusal EdgeCollapser::refusal_to_move(const Star& star, const Interfaces& interfaces) const {
  if (state_.labels.empty()) return Refusal::boundary;
  const auto is_outer = [&](int triangle) {
    return star.is_on_boundary() && star.has(triangle, star.outside);
  };
  bool is_boundary_alone = interfaces.kind != Interfaces::Kind::corner;
  for (int i = 0; i < interfaces.n_faces && is_boundary_alone; ++i) {
    const auto& of = interfaces.faces[static_cast<std::size_t>(i)].triangles;
    is_boundary_alone = is_outer(of[0]) || is_outer(of[1]);
  }
  return is_boundary_alone ? Refusal::boundary : Refusal::regions;
}

}  // namespace lode::tetra_mt::midpoint
