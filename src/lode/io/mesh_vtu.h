#pragma once

#include <string>

#include "lode/io/mesh_file.h"

namespace lode::io {

/// Writes a mesh as VTK's XML UnstructuredGrid, whole or not at all: points (Float64), the field
/// per point (Float32 where that holds all values exactly, else Float64), further ones likewise,
/// and "error" and theirs, "error_NAME", per cell (Float32), as appended raw data. Reports the
/// phase "writing"; cancelled until the file is in place, it leaves none.
[[nodiscard]] Result<void> write_vtu(const std::string& path, const SimplexMesh& mesh,
                                     const MeshWriteOptions& options, Progress& progress);

}  // namespace lode::io
