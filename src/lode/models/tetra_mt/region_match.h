#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/closed_mesh.h"

namespace lode::tetra_mt {

/// The corners of a tetrahedron, ascending, and its region as the file numbers it.
using RegionCell = std::pair<Tetrahedron, std::int64_t>;

/// Of a mesh that has regions; else of nothing.
[[nodiscard]] std::vector<RegionCell> region_cells(const TetraMesh& mesh);

/// Fails where cells that both have are in different regions. Nothing is said where one has none.
[[nodiscard]] Result<void> check_same_regions(std::vector<RegionCell> ours,
                                              std::vector<RegionCell> theirs);

}  // namespace lode::tetra_mt
