#pragma once

#include "lode/core/height_frame.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/quaternary_triangulation/quaternary_triangulation.h"
#include "lode/models/terrain/surface_quadtree/surface_quadtree.h"
#include "lode/refine/demand.h"

namespace lode {

/// The triangles of the squares, or the triangles, that a demand leaves whole, with heights, and
/// errors of these. It sees them in the world of the frame; range: of all heights.
[[nodiscard]] delaunay::Tin tin_of_demand(const surface_quadtree::SurfaceQuadtree& tree,
                                          const HeightFrame& frame, const HeightRange& range,
                                          const Demand& demand);
[[nodiscard]] delaunay::Tin tin_of_demand(
    const quaternary_triangulation::QuaternaryTriangulation& tree, const HeightFrame& frame,
    const HeightRange& range, const Demand& demand);

}  // namespace lode
