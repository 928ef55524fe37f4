#pragma once

#include <optional>
#include <string>

#include "lode/core/mesh.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/regular_grid.h"
#include "lode/core/result.h"

namespace lode::io {

struct MeshWriteOptions {
  std::string comment;           ///< One line for the file's header; what made it, and how.
  Frame frame = Frame::unknown;  ///< Named in the header.
  std::string value_name;        ///< Of the field; empty: "value".
  std::optional<double> time{};  ///< Of all values, of a series.
  Threads threads{};             ///< The bytes are the same for any.
};

/// Writes a mesh in the format that the extension of `path` names (any case), whole or not at all:
/// VTK XML (.vtu), legacy VTK (.vtk), Gmsh 4.1 (.msh) or Exodus II (.e, .exo, .ex2), all binary.
/// Points are doubles. The field is per point, "error", its bound, per cell in the field's unit,
/// further fields likewise with "error_NAME", and regions are "RegionId" per cell. Faces of patches
/// are triangles behind the cells, with "PatchId", in VTK's formats, physical groups in Gmsh's and
/// side sets in Exodus II. A time is the field data's TimeValue in VTK's formats, the step's in
/// Exodus II and that of all data in Gmsh's. Reports the
/// phase "writing"; cancelled until the file is in place, it leaves none. Fails also on what a
/// format has no numbers for, and says so.
[[nodiscard]] Result<void> write_mesh(const std::string& path, const SimplexMesh& mesh,
                                      const MeshWriteOptions& options, Progress& progress);

/// Fails unless `path` has such an extension. Meant to be asked before expensive work starts.
[[nodiscard]] Result<void> check_mesh_path(const std::string& path);

}  // namespace lode::io
