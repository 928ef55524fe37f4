#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"

namespace lode::io {

struct MeshReadOptions {
  /// Most bytes that the file's arrays may take together, decoded; more is refused.
  std::size_t memory_limit = std::numeric_limits<std::size_t>::max();
  /// Of a MEDIT mesh: the file of values at its vertices; empty: that beside it, where one is.
  std::string solution{};
  /// Of a file with a series (CellMesh::times): which step, from 0 in order of time; none: the
  /// last. Others have but what they have.
  std::optional<std::size_t> step{};
};

/// Reads an unstructured or curvilinear mesh with all numeric fields of its points and cells: VTK
/// XML (.vtu, and .vts as hexahedra; pieces are joined, the points between them stay double),
/// legacy VTK (.vtk: UNSTRUCTURED_GRID, and STRUCTURED_GRID as hexahedra), Gmsh (.msh 2.2 and 4.1)
/// and MEDIT (.mesh, and binary .meshb; fields from the .sol or .solb of the same name, see
/// add_medit_solution()), whose groups become the field RegionId where no other is named so. The
/// extension must be a known one; which of the forms it is follows from the content. Cells that
/// vtkGhostType or vtkGhostLevels mark as copies or hidden are left out and counted, as are those
/// of hidden points. The mesh is valid: corners are points, cells have as
/// many as their type says, positions are finite, types are VTK's. Fails, naming the file, on
/// anything else.
[[nodiscard]] Result<CellMesh> read_cell_mesh(const std::string& path,
                                              const MeshReadOptions& options);

}  // namespace lode::io
