#include "lode/api/edge_walk.h"

namespace lode {

std::uint32_t behind_in_grid(std::uint32_t n_columns, std::uint32_t n_rows, std::uint32_t triangle,
                             unsigned edge) {
  const std::uint32_t square = triangle / 2;
  const bool is_above = triangle % 2 != 0;
  // The cut.
  if (edge == (is_above ? 0U : 2U)) return 4 * (triangle ^ 1U) + (is_above ? 2 : 0);
  const std::uint32_t x = square % n_columns;
  const std::uint32_t y = square / n_columns;
  const auto above_in = [](std::uint32_t of, std::uint32_t its_edge) {
    return 4 * (2 * of + 1) + its_edge;
  };
  const auto below_in = [](std::uint32_t of, std::uint32_t its_edge) { return 8 * of + its_edge; };
  if (!is_above && edge == 0)
    return y > 0 ? above_in(square - n_columns, 1) : delaunay::kNoHalfEdge;
  if (!is_above) return x + 1 < n_columns ? above_in(square + 1, 2) : delaunay::kNoHalfEdge;
  if (edge == 1) return y + 1 < n_rows ? below_in(square + n_columns, 0) : delaunay::kNoHalfEdge;
  return x > 0 ? below_in(square - 1, 1) : delaunay::kNoHalfEdge;
}

}  // namespace lode
