#pragma once

#include <string>

#include "lode/io/mesh_file.h"

namespace lode::io {

/// Exodus II in netCDF's classic format with 64-bit offsets: an element block (TETRA, or TRI3) for
/// each region, with its number in the block's name, and as its id where all are positive; one
/// time step with the field as a nodal variable, error and RegionId as element variables, all in
/// doubles. Elements come region by region. For write_mesh(). Fails where a variable takes 4 GiB.
[[nodiscard]] Result<void> write_exodus_mesh(const std::string& path, const SimplexMesh& mesh,
                                             const MeshWriteOptions& options, Progress& progress);

}  // namespace lode::io
