#include "lode/models/terrain/hierarchical_delaunay/edge_refinement.h"

#include <algorithm>

namespace lode::hierarchical_delaunay {

std::vector<ChainPlace> refine_edge(const ReferenceSurface& surface, const ChainPlace& a,
                                    const ChainPlace& b, double limit,
                                    triangle_hierarchy::Crossings crossings) {
  std::vector<ChainPlace> between;
  ChainPlace from = a;
  // The ends of parts still to be looked at, the next one last.
  std::vector<ChainPlace> ahead{b};
  while (!ahead.empty()) {
    const ChainPlace to = ahead.back();
    const auto worst = surface.worst_crossing(from.place, to.place, crossings);
    if (worst.error > limit) {
      ahead.push_back({worst.place, std::max(from.n_moves, to.n_moves) + (worst.is_exact ? 0 : 1)});
      continue;
    }
    ahead.pop_back();
    if (!ahead.empty()) between.push_back(to);
    from = to;
  }
  return between;
}

}  // namespace lode::hierarchical_delaunay
