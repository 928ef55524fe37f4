#pragma once

#include <string>

#include "bench/report.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"

namespace lode::bench {

/// Isosurfaces at the middle of a mesh's first field: of the mesh itself, with VTK's threaded
/// filter in the same run, and of the cut of that isovalue at tolerance 0, whose triangles must be
/// the mesh's bit for bit. Fails where they are not.
[[nodiscard]] Result<void> race_isosurfaces(const std::string& name, const TetraMesh& mesh,
                                            Table& table);

}  // namespace lode::bench
