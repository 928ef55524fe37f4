#pragma once

#include <algorithm>
#include <cstdint>

#include "lode/core/parallel.h"
#include "lode/models/terrain/right_triangle_bisection/bisection_lattice.h"

namespace lode::bisection {

/// As Diamond::is_square says: nodes in the middle of a square, or of its sides.
enum class NodeKind : std::uint8_t { square, side };

/// The first column of the nodes of a reach and kind in row y, a multiple of the reach; others
/// follow in steps of twice the reach. < 0: there are none.
[[nodiscard]] inline std::int32_t first_column(std::int32_t y, std::int32_t reach, NodeKind kind) {
  const bool is_odd = (y & reach) != 0;
  if (kind == NodeKind::square) return is_odd ? reach : -1;
  return is_odd ? 0 : reach;
}

/// visit(node) of all nodes of a reach and kind whose diamonds have some area, row by row; rows at
/// the same time.
template <typename Visit>
void for_each_node(const Lattice& lattice, std::int32_t reach, NodeKind kind, Threads threads,
                   const Visit& visit) {
  const auto n_rows =
      static_cast<std::size_t>(std::min(lattice.side(), lattice.last().y + reach - 1) / reach + 1);
  const std::size_t grain = static_cast<std::size_t>(std::max(1, 4096 / lattice.side() * reach));
  parallel_for(n_rows, threads, grain, [&](std::size_t row, int) {
    const std::int32_t y = static_cast<std::int32_t>(row) * reach;
    const std::int32_t first = first_column(y, reach, kind);
    if (first < 0) return;
    for (std::int32_t x = first; x <= lattice.side() && x - reach < lattice.last().x;
         x += 2 * reach)
      visit(LatticePoint{x, y});
  });
}

/// Joins own errors into nested ones: a node's with those of all that wait for it.
void nest_errors(const Lattice& lattice, Threads threads, float* errors);

}  // namespace lode::bisection
