#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/cell_mesh.h"

namespace lode::io {

/// A point that sees the faces of a cell, given as triangles that are wound as seen from
/// outside: with each of them it makes a tetrahedron of positive volume, but for those whose height
/// is at most a millionth of their longest side, whose planes roundings turn. The
/// middle if it does; else the point that is farthest from all planes of the triangles, inside of
/// them. Where there is none, the middle if it makes no negative volume (the cell is flat), else
/// nothing.
[[nodiscard]] std::optional<Vec3d> find_centre(const CellMesh& mesh, const Vec3d& middle,
                                               std::span<const std::array<std::uint32_t, 3>> faces);

/// Of a field of one component at points: the mean at a cell's corners, each given once, which is
/// what the linear function that fits them best has there (least squares), and at another centre
/// what that function has, within the corners' range. So linear fields stay what they are.
[[nodiscard]] double value_at_centre(const CellMesh& mesh, std::span<const std::uint32_t> corners,
                                     const Vec3d& centre, const std::vector<double>& values);

}  // namespace lode::io
