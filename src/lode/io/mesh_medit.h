#pragma once

#include <string>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/io/mesh_reader.h"

namespace lode::io {

/// MEDIT's meshes, text (.mesh) or binary (.meshb), in three dimensions: vertices, and edges,
/// triangles, quadrilaterals, tetrahedra, prisms, pyramids and hexahedra, whose references become
/// the cell field RegionId; other keywords are passed over. Fields come from the solution that the
/// options name, or that lies beside it. For read_cell_mesh(), which checks the corners of cells.
[[nodiscard]] Result<CellMesh> read_medit_mesh(const std::string& path,
                                               const MeshReadOptions& options);

}  // namespace lode::io
