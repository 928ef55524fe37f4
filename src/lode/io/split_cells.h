#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"

namespace lode::io {

using Tetrahedron = std::array<std::uint32_t, 4>;

/// Tetrahedra of points, and of new vertices that are numbered after them.
struct SplitCells {
  std::vector<Tetrahedron> tetrahedra;
  std::vector<std::uint32_t> cells;         ///< By tetrahedron: what it is part of.
  std::vector<std::uint32_t> centre_cells;  ///< By new vertex: the cell that it is within,
  std::vector<Vec3d> centres;               ///< and where it is.
  std::uint64_t n_repeating = 0;            ///< Left out, since they repeat a corner.
};

/// Splits the solid cells, all of types that can be; cells without a solid are passed over. A cell
/// of positive volume gives tetrahedra of positive volume in all, wedges where their first triangle
/// faces the other one. Fails when there are more than 32 bits number, on open polyhedra, and on
/// these and quadratic cells in which no point sees all triangles that their faces are cut into.
[[nodiscard]] Result<SplitCells> split_cells(const CellMesh& mesh);

}  // namespace lode::io
