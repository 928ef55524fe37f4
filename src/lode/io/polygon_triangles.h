#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/vec.h"

namespace lode::io {

/// The triangles of a polygon of three points or more, wound as it is: a fan round its smallest
/// point, whatever the points of triangles and quadrilaterals are. Of other polygons where that
/// folds, as they are not convex, ears are cut, the highest first (Meisters, Polygons have ears,
/// 1975); the fan stays where there are none, and beyond 100 points. The same triangles come of the
/// polygon from another point on, or the other way round.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> polygon_triangles(
    std::span<const Vec3d> points, std::span<const std::uint32_t> polygon);

}  // namespace lode::io
