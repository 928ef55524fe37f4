#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/models/tetra_mt/closed_mesh.h"

namespace lode::tetra_mt {

/// How near to the base that was asked for is enough: its cells, times this.
inline constexpr double kNearBase = 1.002;

/// What is left of a mesh when all collapses are done.
struct LeftMesh {
  std::vector<std::uint32_t> vertices;
  std::vector<std::uint32_t> slots;   ///< Of tetrahedra, those to the vertex outside among them.
  std::vector<std::uint32_t> places;  ///< Room for a collapser of all of it.
};

/// Of a BuildState or a State, to count why each vertex is still there. Where they are there as no
/// more cells had to go, samples that went are forgotten: to ask for them takes too long, and they
/// hardly ever refuse.
template <typename State>
[[nodiscard]] LeftMesh left_mesh(State& state, std::uint64_t base_cells) {
  if (static_cast<double>(state.n_cells) <= kNearBase * static_cast<double>(base_cells))
    std::ranges::fill(state.first_sample, kNone);
  LeftMesh left;
  for (std::uint32_t v = 0; v < state.outside; ++v)
    if (state.is_there[v] != 0) left.vertices.push_back(v);
  for (std::uint32_t slot = 0; slot < state.tetrahedra.size(); ++slot)
    if (state.tetrahedra[slot][0] != kNone) left.slots.push_back(slot);
  left.places.resize(state.outside + std::size_t{1});
  return left;
}

}  // namespace lode::tetra_mt
