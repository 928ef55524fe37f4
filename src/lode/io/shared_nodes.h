#pragma once

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"

namespace lode::io {

/// Fails where a mesh has quadratic cells and solid cells share the corners of an edge or face but
/// not the node in its middle, where a face with four corners meets two triangles, and where
/// quadratic cells touch polyhedra.
[[nodiscard]] Result<void> check_shared_nodes(const CellMesh& mesh);

}  // namespace lode::io
