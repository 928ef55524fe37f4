#pragma once

#include <cstdint>
#include <optional>

#include "lode/models/terrain/quaternary_triangulation/quaternary_triangulation.h"
#include "lode/models/terrain/surface_quadtree/surface_quadtree.h"

namespace lode {

/// The least tolerance, a float, at which a tree has no more than so many triangles (two of each
/// square), found by halving between floats, as all its errors are; nothing where it always has
/// more. O(max_cells) 32 times, as counting stops at one more.
[[nodiscard]] std::optional<double> tolerance_of_cells(
    const surface_quadtree::SurfaceQuadtree& tree, std::uint64_t max_cells);
[[nodiscard]] std::optional<double> tolerance_of_cells(
    const quaternary_triangulation::QuaternaryTriangulation& tree, std::uint64_t max_cells);

}  // namespace lode
