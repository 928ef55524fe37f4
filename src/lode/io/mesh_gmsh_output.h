#pragma once

#include <string>

#include "lode/io/mesh_file.h"

namespace lode::io {

/// Gmsh's .msh, version 4.1, binary: an entity and a physical group for each region, the field as
/// $NodeData, error as $ElementData. A group's tag is the region's number; where one of these is
/// not positive tags go from 1 on, and the numbers are $ElementData RegionId. Patches are entities
/// and physical groups of two dimensions, with their names. Nodes and elements are numbered from 1,
/// elements region by region, then patch by patch. For write_mesh(). Fails where a tag takes more
/// than 32 bits.
[[nodiscard]] Result<void> write_gmsh_mesh(const std::string& path, const SimplexMesh& mesh,
                                           const MeshWriteOptions& options, Progress& progress);

}  // namespace lode::io
