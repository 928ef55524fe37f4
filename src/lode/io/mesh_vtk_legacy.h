#pragma once

#include <string>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/io/mesh_reader.h"

namespace lode::io {

/// Legacy VTK (.vtk), ASCII or BINARY: UNSTRUCTURED_GRID with CELLS as in files of version 2 to 4
/// or as OFFSETS and CONNECTIVITY (5.1), and STRUCTURED_GRID. For read_cell_mesh(), which checks
/// the corners of cells.
[[nodiscard]] Result<CellMesh> read_vtk_legacy_mesh(const std::string& path,
                                                    const MeshReadOptions& options);

}  // namespace lode::io
