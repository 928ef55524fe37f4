#pragma once

#include "lode/core/tetra_mesh.h"

class vtkUnstructuredGrid;

namespace lode::bench {

/// Copies a mesh of tetrahedra and its first field, both as doubles, into VTK's memory.
void fill_grid(const TetraMesh& mesh, vtkUnstructuredGrid& grid);

}  // namespace lode::bench
