#pragma once

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"

namespace lode::io {

/// Takes the arrays vtkGhostType and vtkGhostLevels out of the fields, leaves out the cells that
/// they mark as another piece's or hidden or that have a hidden point, and counts them. Points
/// stay. Fails when such an array has several components.
[[nodiscard]] Result<void> leave_out_ghosts(CellMesh& mesh);

/// The place of a ghost array among the fields, or their number.
[[nodiscard]] std::size_t find_ghost_type(const std::vector<MeshField>& fields);

/// Whether a value of vtkGhostType marks a cell of another piece.
[[nodiscard]] bool is_ghost(double type);

}  // namespace lode::io
