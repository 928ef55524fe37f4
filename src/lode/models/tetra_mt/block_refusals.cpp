// Why vertices stay.
#include <algorithm>
#include <limits>

#include "lode/models/tetra_mt/block_collapser.h"

namespace lode::tetra_mt {

RefusalCounts BlockCollapser::count_refusals() {
  RefusalCounts counts;
  for (std::uint32_t v = 0; v < live_.n_own(); ++v)
    if (!live_.star(v).empty()) counts.add(refusal_of(v));
  return counts;
}

Refusal BlockCollapser::refusal_of(std::uint32_t vertex) {
  if (!gatherer_.gather(vertex, star_)) return Refusal::crowded;
  if (!StarGatherer::is_manifold(star_)) return Refusal::non_manifold;
  if (is_extremum()) return Refusal::extremum;
  if (!look_at_star()) return Refusal::regions;
  gather_samples();
  Refusal farthest = Refusal::boundary;
  for (int kept = 0; kept < star_.n_link && farthest != Refusal::limit; ++kept)
    if (kept != star_.outside) farthest = std::max(farthest, refusal_to(kept));
  return farthest;
}

/// Of one edge.
Refusal BlockCollapser::refusal_to(int kept) {
  if (moved_by(kept) == std::numeric_limits<float>::infinity())
    return state_.labels.empty() || is_on_domain_boundary_alone() ? Refusal::boundary
                                                                  : Refusal::regions;
  if (!make_fan_to(kept)) return Refusal::shape;
  if (!gatherer_.may_collapse(star_, kept, std::numeric_limits<int>::max()) || !keeps_regions(kept))
    return Refusal::topology;
  if (!gatherer_.may_collapse(star_, kept, rules_.max_link)) return Refusal::crowded;
  return cover_samples(kept) ? Refusal::limit : Refusal::rounding;
}

/// Whether all its faces between regions have the outside on one side.
bool BlockCollapser::is_on_domain_boundary_alone() const {
  const auto is_outer = [&](int triangle) {
    return star_.is_on_boundary() && star_.has(triangle, star_.outside);
  };
  for (int i = 0; i < interfaces_.n_faces; ++i) {
    const auto& of = interfaces_.faces[static_cast<std::size_t>(i)].triangles;
    if (!is_outer(of[0]) && !is_outer(of[1])) return false;
  }
  return true;
}

}  // namespace lode::tetra_mt
