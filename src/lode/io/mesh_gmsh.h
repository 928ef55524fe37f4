#pragma once

#include <string>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/io/mesh_reader.h"

namespace lode::io {

/// Gmsh's .msh of versions 2.2 and 4.1, text or binary. Physical groups become the cell field
/// RegionId (0: none; of several the first), with their names, $NodeData and
/// $ElementData fields; nodes and elements without a value have NaN. Fields of one name and shape
/// at several times are a series, of which one step is read (choose_gmsh_step()); of others with
/// one name the later ones are called NAME@STEP, after their time step. Other sections are passed
/// over. For read_cell_mesh(), which checks cells.
[[nodiscard]] Result<CellMesh> read_gmsh_mesh(const std::string& path,
                                              const MeshReadOptions& options);

}  // namespace lode::io
