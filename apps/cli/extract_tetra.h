#pragma once

#include "extract_mesh.h"

namespace lode::cli {

/// Looks at the arguments for a mesh of cells alone: of it isosurfaces and meshes are made.
[[nodiscard]] Result<void> check_tetra_job(const MeshJob& job);
/// Builds the hierarchy of a mesh of cells in memory, and writes the mesh or isosurface of a
/// query.
[[nodiscard]] Result<Outcome> run_tetra_job(const MeshJob& job, Session& session);

}  // namespace lode::cli
