#pragma once

#include <array>
#include <cstddef>

#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"

namespace lode::triangle_hierarchy {

/// ReferenceSurface::measure_samples() of a raster. O(rows + samples).
[[nodiscard]] SampleErrors measure_samples(const FineGrid& grid,
                                           const std::array<Place, 3>& corners, EdgeSet open);

/// ReferenceSurface::count_samples() of a raster. O(rows).
[[nodiscard]] std::size_t count_samples(const FineGrid& grid,
                                        const std::array<LatticePoint, 3>& corners);

}  // namespace lode::triangle_hierarchy
