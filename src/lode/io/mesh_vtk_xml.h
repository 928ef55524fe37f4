#pragma once

#include <string>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/io/mesh_reader.h"

namespace lode::io {

/// VTK XML UnstructuredGrid (.vtu) and StructuredGrid (.vts). For read_cell_mesh(), which checks
/// the corners of cells.
[[nodiscard]] Result<CellMesh> read_vtk_xml_mesh(const std::string& path,
                                                 const MeshReadOptions& options);

}  // namespace lode::io
