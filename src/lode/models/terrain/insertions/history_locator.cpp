#include "lode/models/terrain/insertions/history_locator.h"

#include <algorithm>

#include "lode/delaunay/lattice_side.h"
#include "lode/models/terrain/insertions/descent.h"

namespace lode::insertions {
namespace {

std::vector<std::array<std::uint32_t, 3>> base_corners(const History& history) {
  std::vector<std::array<std::uint32_t, 3>> corners;
  for (std::uint32_t t = 0; t < history.n_base_triangles(); ++t)
    corners.push_back(history.triangles[t].corner);
  return corners;
}

}  // namespace

HistoryLocator::HistoryLocator(const History& history)
    : history_(&history), start_(history, base_corners(history)) {}

std::optional<std::uint32_t> HistoryLocator::find(const NodeSet& nodes,
                                                  const delaunay::Point& p) const {
  const auto is_left = [&](std::uint32_t a, std::uint32_t b) {
    return delaunay::side_of(history_->vertices[a], history_->vertices[b], p) >= 0;
  };
  const auto start = start_.find(p);
  if (!start) return {};
  std::uint32_t at = *start;
  while (nodes.has(history_->triangles[at].death)) {
    const std::uint32_t death = history_->triangles[at].death;
    // In the cavity p is in one of the sectors round the new vertex.
    const std::uint32_t end = history_->first_made[death + 1];
    at = history_->first_made[death];
    for (; at + 1 < end; ++at) {
      const auto& corner = history_->triangles[at].corner;
      if (is_left(corner[1], corner[2]) && is_left(corner[2], corner[0])) break;
    }
  }
  return at;
}

std::vector<std::uint32_t> zoom_in(const History& history, const NodeSet& nodes,
                                   const delaunay::Window& window) {
  std::vector<std::uint32_t> found;
  Descent descent(history);
  for (std::uint32_t t = 0; t < history.n_base_triangles(); ++t)
    descent.run(
        t, nodes,
        [&](std::uint32_t other) {
          return delaunay::meets_window(corners_of(history, history.triangles[other].corner),
                                        window);
        },
        [&](std::uint32_t other) { found.push_back(other); });
  std::ranges::sort(found);
  return found;
}

}  // namespace lode::insertions
