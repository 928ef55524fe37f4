#pragma once

#include <cstdint>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"

namespace lode::io {

/// Of a mesh with quadratic cells, how many faces of two of them have the same corners and other
/// nodes elsewhere in the middles of their edges, as at a crack, and do not meet. Fails where some
/// cells at an edge, or one at a face, have a node in its middle and others none, where two such
/// nodes are at one place, where a face with four corners meets two triangles, and where quadratic
/// cells share an edge with polyhedra.
[[nodiscard]] Result<std::uint64_t> check_shared_nodes(const CellMesh& mesh);

}  // namespace lode::io
