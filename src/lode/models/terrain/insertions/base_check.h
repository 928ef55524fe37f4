#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/models/terrain/insertions/overlap.h"

namespace lode::insertions {

/// Whether triangles, which turn left, are a triangulation of cells of the lattice: they share
/// whole edges or none, what is left of those runs along columns and rows, and no two overlap.
/// O(n log n).
[[nodiscard]] bool cover_cells_once(std::span<const LatticeCorners> triangles);

/// Whether triangles, which turn left, given by numbers of nodes, are a triangulation of a part of
/// the plane: they share whole edges or none, and no two overlap. False also where more than
/// kMostOutlineEdges of the outline meet at a node. O(n log n) usually.
[[nodiscard]] bool cover_part_once(std::span<const delaunay::LatticePoint> nodes,
                                   std::span<const std::array<std::uint32_t, 3>> triangles);

/// The outline's triangulation takes time by its square.
inline constexpr std::uint32_t kMostOutlineEdges = 8192;

}  // namespace lode::insertions
