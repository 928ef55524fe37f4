#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/io/tetrahedra.h"

namespace lode::io {

/// The field of the cells that tells regions apart: its place among them, or their number. Of
/// several the one whose name comes first in the list of TetraOptions; whole numbers of one
/// component, of any type. Fails when the one that the options name is not there or not such.
[[nodiscard]] Result<std::size_t> find_regions(const CellMesh& mesh, const TetraOptions& options);

/// Fields whose names are such, but that are not taken, with the reason: "Material (0.5, which is
/// no whole number)". `regions`: find_regions().
[[nodiscard]] std::vector<std::string> find_regions_not_taken(const CellMesh& mesh,
                                                              std::size_t regions);

}  // namespace lode::io
