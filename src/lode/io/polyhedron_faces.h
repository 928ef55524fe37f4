#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"

namespace lode::io {

/// The faces of a polyhedron as triangles that are wound as seen from outside, each face as a fan
/// round its smallest point. Faces may be wound either way in the mesh: they are turned to agree,
/// and then all of them where they enclose a negative volume. Fails unless they are one closed
/// surface that has two sides.
[[nodiscard]] Result<std::vector<std::array<std::uint32_t, 3>>> outward_triangles(
    const CellMesh& mesh, std::size_t cell);

/// The mean of the corners of a polyhedron's faces, each counted once.
[[nodiscard]] Vec3d centre_of(const CellMesh& mesh, std::size_t cell);

/// The same of the values of a field of one component at points.
[[nodiscard]] double mean_at_corners(const CellMesh& mesh, std::size_t cell,
                                     const std::vector<double>& values);

}  // namespace lode::io
