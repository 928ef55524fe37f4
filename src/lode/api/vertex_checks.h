#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/api/point_terrain.h"
#include "lode/api/verify_report.h"
#include "lode/core/height_grid.h"
#include "lode/core/height_points.h"
#include "lode/core/lattice_point.h"

namespace lode {

/// Reports whether vertices of a model are samples of the raster, and have their heights.
void check_vertices(std::span<const LatticePoint> vertices, std::span<const double> heights,
                    const HeightGrid& grid, VerifyReport& report);
/// The same of points.
void check_vertices(std::span<const LatticePoint> vertices, std::span<const double> heights,
                    const HeightPoints& points, VerifyReport& report);

/// Reports whether a model's fixed edges, two vertices each, are those of the terrain that are not
/// on its outline.
void check_lines(std::span<const LatticePoint> vertices,
                 std::span<const std::array<std::uint32_t, 2>> lines, const PointTerrain& terrain,
                 VerifyReport& report);

}  // namespace lode
