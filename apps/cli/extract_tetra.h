#pragma once

#include "extract_mesh.h"

namespace lode::cli {

/// Looks at the arguments for a mesh of cells alone.
[[nodiscard]] Result<void> check_tetra_job(const MeshJob& job);
/// Builds the hierarchy of a mesh of cells in memory, and writes the mesh, isosurfaces, sections or
/// boundary of a query.
[[nodiscard]] Result<Outcome> run_tetra_job(const MeshJob& job, Session& session);

}  // namespace lode::cli
