#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/io/vtk_xml_extent.h"

namespace lode::io {

/// How many points or cells there are. Fails when it is more than a mesh can have.
[[nodiscard]] Result<std::uint64_t> count_places(const std::string& path, const Index3& dims);

/// Of the cells between points of these dims.
[[nodiscard]] Index3 cell_dims(const Index3& dims);

/// Fails unless the grid has two points or more along each axis.
[[nodiscard]] Result<void> check_solid(const std::string& path, const Index3& dims);

/// Makes the hexahedra between the points of a mesh, which are those of a grid, x fastest.
void make_hexahedra(const Index3& dims, CellMesh& mesh);

/// A part of a grid: its points and fields.
struct GridPiece {
  VtkExtent extent;
  CellMesh content;
};

/// The whole grid with its hexahedra. Of pieces that overlap, a cell's values come from the first
/// that does not call it a ghost. Fails unless the pieces lie in the extent and cover it.
[[nodiscard]] Result<CellMesh> join_grid(const std::string& path, const VtkExtent& extent,
                                         std::vector<GridPiece>&& pieces);

}  // namespace lode::io
