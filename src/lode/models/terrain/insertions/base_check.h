#pragma once

#include <span>

#include "lode/models/terrain/insertions/overlap.h"

namespace lode::insertions {

/// Whether triangles, which turn left, are a triangulation of cells of the lattice: they share
/// whole edges or none, what is left of those runs along columns and rows, and no two overlap.
/// O(n log n).
[[nodiscard]] bool cover_cells_once(std::span<const LatticeCorners> triangles);

}  // namespace lode::insertions
