#include "lode/models/terrain/insertions/history.h"

#include "lode/core/expects.h"

namespace lode::insertions {

std::uint64_t History::n_bytes() const {
  return vertices.size() * sizeof(vertices[0]) + heights.size() * sizeof(heights[0]) +
         triangles.size() * sizeof(triangles[0]) +
         (first_made.size() + removed.size() + first_removed.size()) * sizeof(std::uint32_t);
}

std::uint32_t time_within(const History& history, double tolerance) {
  LODE_EXPECTS(history.is_worst_first());
  for (std::uint32_t k = 0; k < history.n_nodes(); ++k)
    if (static_cast<double>(history.error_before(k)) <= tolerance) return k;
  return history.n_nodes();
}

std::vector<std::uint32_t> times_of(const History& history, std::span<const double> levels) {
  std::vector<std::uint32_t> times;
  for (const double level : levels) times.push_back(time_within(history, level));
  return times;
}

}  // namespace lode::insertions
