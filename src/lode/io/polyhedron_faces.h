#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"

namespace lode::io {

/// The faces of a polyhedron as triangles that are wound as seen from outside, each face as
/// polygon_triangles() has it. Faces may be wound either way in the mesh: they are turned to agree,
/// and then all of them where they enclose a negative volume. Fails unless they are one closed
/// surface that has two sides.
[[nodiscard]] Result<std::vector<std::array<std::uint32_t, 3>>> outward_triangles(
    const CellMesh& mesh, std::size_t cell);

/// The corners of a polyhedron's faces, each once, ascending.
[[nodiscard]] std::vector<std::uint32_t> distinct_corners(const CellMesh& mesh, std::size_t cell);

[[nodiscard]] Vec3d mean_position(const CellMesh& mesh, std::span<const std::uint32_t> corners);

}  // namespace lode::io
