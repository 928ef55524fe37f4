#pragma once

#include <string>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/io/mesh_reader.h"

namespace lode::io {

/// The solution that lies beside a MEDIT mesh: the file of its name that ends in .sol or, first
/// where the mesh is binary, in .solb. Empty where there is none.
[[nodiscard]] std::string medit_solution_of(const std::string& mesh_path);

/// Appends a solution's values at vertices as fields of the points: "solution", or of several
/// "solution_1" and so on; scalars, vectors, and tensors as 9 components, row by row. Solutions of
/// edges and cells are listed as left out. Fails, naming file and line, where one at vertices is
/// not of as many as the mesh has, and where there is none though the options name this file.
[[nodiscard]] Result<void> add_medit_solution(const std::string& path,
                                              const MeshReadOptions& options, CellMesh& mesh);

}  // namespace lode::io
