#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/result.h"

namespace lode::tetra_mt {

using Tetrahedron = std::array<std::uint32_t, 4>;

inline constexpr std::uint32_t kNone = 0xFFFFFFFFU;

/// By place of a corner, those of the others, so turned that (corner, others) is as corners are.
inline constexpr std::array<std::array<std::uint8_t, 3>, 4> kOtherPlaces{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// The other corners of a tetrahedron, so turned that (corners[place], others) is as corners is.
[[nodiscard]] inline std::array<std::uint32_t, 3> others(const Tetrahedron& corners,
                                                         std::size_t place) {
  const auto& at = kOtherPlaces[place];
  return {corners[at[0]], corners[at[1]], corners[at[2]]};
}

/// By tetrahedron and corner: the one across from it, kNone where its face has one or more than
/// two.
[[nodiscard]] std::vector<std::array<std::uint32_t, 4>> find_across(
    std::span<const Tetrahedron> tetrahedra);

/// Appends a tetrahedron on each face of the boundary, to one vertex outside, number n_vertices: so
/// each vertex of a manifold has a sphere for its link, and all that follows treats the boundary as
/// it does the rest. Fails when a face has more than two tetrahedra.
[[nodiscard]] Result<void> close_boundary(std::uint32_t n_vertices,
                                          std::vector<Tetrahedron>& tetrahedra, Threads threads);

}  // namespace lode::tetra_mt
