#pragma once

#include <string>

#include "input.h"
#include "lode/api/files.h"

namespace lode::cli {

/// Whether `path` is a mesh that the program lode-vtk-import reads for us: Exodus II (.e .exo .ex2
/// .g), CGNS (.cgns), EnSight (.case .encas), OpenFOAM (.foam, or a directory with
/// system/controlDict), PLOT3D (.xyz .p3d), VTK XML in several files (.pvtu .pvts .vtm), or .vtu
/// and .vts whose first bytes say that they are compressed by LZ4 or LZMA.
[[nodiscard]] bool needs_vtk_import(const std::string& path);

/// Whether a mesh may hold several steps, of which --time chooses one: such files, and Gmsh's.
[[nodiscard]] bool may_have_steps(const std::string& path);

/// is_cell_mesh_path() and holds_tetrahedra(), or such a mesh.
[[nodiscard]] bool is_cells_path(const std::string& path);
[[nodiscard]] bool holds_cells(const std::string& path);

/// read_cell_mesh(), by way of lode-vtk-import where that is needed: it writes to a temporary
/// directory, what it says is noted. --time chooses the step of a series, which is noted, too.
/// Fails, saying what to install, where the program is neither beside this one nor in PATH.
[[nodiscard]] Result<CellMesh> read_cells(const std::string& path, const ReadingArguments& reading,
                                          Session& session);

}  // namespace lode::cli
