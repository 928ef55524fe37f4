#pragma once

#include <cstddef>
#include <cstdint>

#include "lode/core/cell_mesh.h"

namespace lode::io {

/// Cells of order 1 and 2 in VTK's Lagrange types become the types that they are without these;
/// pyramids of 14 nodes stay.
void name_lagrange_cells(CellMesh& mesh);

/// Puts middles of edges of quadratic hexahedra and wedges in VTK's order where that brings them
/// nearer to their edges than the order of the file does: Exodus II has those of upright edges
/// first, and so have files that VTK wrote in it the other way, and Lagrange hexahedra before VTK
/// 9.1 had the last two exchanged. How many cells that are.
[[nodiscard]] std::uint64_t order_middles(CellMesh& mesh);

/// Leaves of all solid cells of higher order their corners.
void linearise(CellMesh& mesh);

/// Whether linearise() makes something of a cell.
[[nodiscard]] bool can_linearise(const CellMesh& mesh, std::size_t cell);

}  // namespace lode::io
