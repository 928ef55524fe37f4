#pragma once

#include <string>

#include "lode/io/mesh_file.h"

namespace lode::io {

/// Legacy VTK, version 3.0, binary: an UNSTRUCTURED_GRID with the field as SCALARS of its points
/// (float where that holds all values exactly, else double), error (float) and RegionId
/// (vtktypeint64) as fields of its cells. For write_mesh(). Fails where a count takes more than 32
/// bits.
[[nodiscard]] Result<void> write_vtk_legacy_mesh(const std::string& path, const SimplexMesh& mesh,
                                                 const MeshWriteOptions& options,
                                                 Progress& progress);

}  // namespace lode::io
