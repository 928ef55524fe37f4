#pragma once

#include <array>
#include <cstdlib>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// Whether cells that holes have left lie round an edge p - q of a cut in two arcs, with removed
/// ones between them: a surface that crosses the edge has a vertex for each arc, else two sheets
/// would meet in one. Only along an axis do four cells meet round an edge, and each simplex there
/// lies in one quadrant, or all four are alike; of longer edges than a cell's the middle is mixed
/// then (see is_mixed()), so that no cut has them. is_removed(cell): of unit cells in the data, by
/// lowest corner.
template <typename IsRemoved>
[[nodiscard]] bool is_pinched(const Shape<3>& shape, const Index<3>& p, const Index<3>& q,
                              const IsRemoved& is_removed) {
  std::int32_t n_steps = 0;
  std::size_t along = 0;
  Index<3> first;
  for (std::size_t i = 0; i < 3; ++i) {
    first[i] = std::min(p[i], q[i]);
    n_steps += std::abs(p[i] - q[i]);
    if (p[i] != q[i]) along = i;
  }
  if (n_steps != 1) return false;
  std::array<bool, 4> is_present{};
  for (std::size_t quadrant = 0; quadrant < 4; ++quadrant) {
    Index<3> cell = first;
    cell[(along + 1) % 3] -= static_cast<std::int32_t>(1 - (quadrant & 1U));
    cell[(along + 2) % 3] -= static_cast<std::int32_t>(1 - (quadrant >> 1U));
    bool is_real = true;
    for (std::size_t i = 0; i < 3; ++i)
      is_real = is_real && cell[i] >= 0 && cell[i] < shape.dims[i] - 1;
    is_present[quadrant] = is_real && !is_removed(cell);
  }
  return is_present[0] == is_present[3] && is_present[1] == is_present[2] &&
         is_present[0] != is_present[1];
}

/// Which of the arcs round such an edge a simplex that has it lies in.
[[nodiscard]] inline bool is_in_second_arc(const std::array<Index<3>, 4>& corners,
                                           const Index<3>& p, const Index<3>& q) {
  std::size_t along = 0;
  while (p[along] == q[along]) ++along;
  const std::size_t across = (along + 1) % 3;
  std::int32_t sum = 0;
  for (const Index<3>& corner : corners) sum += corner[across] - p[across];
  return sum > 0;
}

}  // namespace lode::diamond
