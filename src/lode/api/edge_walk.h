#pragma once

#include <cstdint>

#include "lode/delaunay/lattice_mesh.h"

namespace lode {

/// Goes from triangle to triangle through random edges, not back through the one that it came by
/// but from dead ends: behind(triangle, edge) is what a twin is. Returns how many edges it crossed
/// in so many tries; those that have nothing behind them cross none.
template <typename Behind>
std::uint64_t walk_edges(std::uint32_t start, std::uint64_t n_tries, std::uint64_t seed,
                         const Behind& behind) {
  std::uint32_t triangle = start;
  unsigned entered = 0;
  std::uint64_t n_crossed = 0;
  for (std::uint64_t i = 0; i < n_tries; ++i) {
    // Knuth's, of which the upper bits are good.
    seed = seed * 6364136223846793005U + 1442695040888963407U;
    const unsigned edge = (entered + 1 + static_cast<unsigned>(seed >> 63)) % 3;
    const std::uint32_t next = behind(triangle, edge);
    if (next == delaunay::kNoHalfEdge) {
      entered = edge;
      continue;
    }
    triangle = next >> 2;
    entered = next & 3;
    ++n_crossed;
  }
  return n_crossed;
}

/// What is behind an edge of a triangle in a grid of so many columns and rows of squares, each cut
/// from its lower left corner to its upper right one: the triangle below the cut comes first, and
/// its edges start with the lower side; those of the one above with the cut.
[[nodiscard]] std::uint32_t behind_in_grid(std::uint32_t n_columns, std::uint32_t n_rows,
                                           std::uint32_t triangle, unsigned edge);

}  // namespace lode
