#include "lode/models/terrain/delaunay_pyramid/history.h"

#include <bit>

namespace lode::delaunay_pyramid {

std::uint64_t History::n_bytes() const {
  return vertices.size() * sizeof(vertices[0]) + heights.size() * sizeof(heights[0]) +
         triangles.size() * sizeof(triangles[0]) +
         (first_made.size() + removed.size() + first_removed.size()) * sizeof(std::uint32_t);
}

float to_stored_error(float error) {
  const auto bits = std::bit_cast<std::uint32_t>(error);
  return std::bit_cast<float>((bits + 0xFFFFU) & 0xFFFF0000U);
}

std::uint32_t time_within(const History& history, double tolerance) {
  for (std::uint32_t k = 0; k < history.n_nodes(); ++k)
    if (static_cast<double>(history.error_before(k)) <= tolerance) return k;
  return history.n_nodes();
}

}  // namespace lode::delaunay_pyramid
