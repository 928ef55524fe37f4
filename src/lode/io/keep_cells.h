#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/cell_mesh.h"

namespace lode::io {

/// Leaves out the cells that are marked 0, with their values; points stay.
void keep_cells(const std::vector<std::uint8_t>& is_kept, CellMesh& mesh);

}  // namespace lode::io
