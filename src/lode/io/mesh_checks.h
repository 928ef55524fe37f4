#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"

namespace lode::io {

/// Points and cells have 32-bit numbers, of which the last stands for none.
inline constexpr std::uint64_t kMaxMeshCount = std::numeric_limits<std::uint32_t>::max() - 1;

/// Fails unless the cells' ends rise. `what` names them in messages.
[[nodiscard]] Result<void> check_rising(const std::string& path, std::string_view what,
                                        std::span<const std::uint64_t> ends);

/// Appends the faces of the next cell, a polyhedron, from a list as VTK has it: their number, then
/// each as its number of corners and these. Fails unless they fill the list, of at least four
/// faces of at least three corners, each below `n_points`.
[[nodiscard]] Result<void> append_faces(std::span<const std::uint64_t> list, std::uint64_t n_points,
                                        CellMesh& mesh);

/// Fails unless types are VTK's, each cell has as many corners as its type says, and they are
/// points whose positions are finite; points that no cell has are put where another is if theirs
/// are not. Sets has_narrow_points.
[[nodiscard]] Result<void> check_cell_mesh(CellMesh& mesh);

}  // namespace lode::io
