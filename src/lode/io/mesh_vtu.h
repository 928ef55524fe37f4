#pragma once

#include <string>

#include "lode/core/mesh.h"
#include "lode/core/progress.h"
#include "lode/core/regular_grid.h"
#include "lode/core/result.h"

namespace lode::io {

struct MeshWriteOptions {
  std::string comment;           ///< One line for the file's header; what made it, and how.
  Frame frame = Frame::unknown;  ///< Named in the header.
  std::string value_name;        ///< Of the field; empty: "value".
};

/// Writes a mesh as VTK's XML UnstructuredGrid, whole or not at all: points (Float64), the field
/// per point (Float32 where that holds all values exactly, else Float64) and "error" per
/// cell (Float32), as appended raw data. Reports the phase "writing"; cancelled until the file
/// is in place, it leaves none.
[[nodiscard]] Result<void> write_vtu(const std::string& path, const SimplexMesh& mesh,
                                     const MeshWriteOptions& options, Progress& progress);

/// Fails unless `path` ends in .vtu (any case). Meant to be asked before expensive work starts.
[[nodiscard]] Result<void> check_mesh_path(const std::string& path);

}  // namespace lode::io
