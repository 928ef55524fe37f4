#pragma once

#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"

namespace lode::tetra_mt {

/// Whether edges of a mesh can be collapsed: corners and regions are there, positions up to 2e100
/// from the origin, and fields have finite values, one for each vertex, of a range that doubles
/// hold.
[[nodiscard]] Result<void> check_mesh(const TetraMesh& mesh);

}  // namespace lode::tetra_mt
