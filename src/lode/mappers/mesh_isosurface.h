#pragma once

#include "lode/core/mesh.h"
#include "lode/core/surface.h"

namespace lode {

/// Appends the triangles where the field of a mesh of tetrahedra is the isovalue, counter-clockwise
/// seen from lower values; `value >= isovalue` is inside. Vertices, one for each edge that is
/// crossed, have positions relative to surface.origin and the isovalue; they keep away from the
/// ends of their edges by `margin` (world units), or a quarter of the edge, so that rounding to
/// float32 makes no two of them one. Returns the largest error of a cell that is crossed. O(cells).
double add_isosurface(const SimplexMesh& mesh, double isovalue, double margin, Surface& surface);

/// Of positions relative to an origin: eight units in the last place of float32 at the largest
/// coordinate of a box round all of them.
[[nodiscard]] double rounding_margin(const SimplexMesh& mesh, const Vec3d& origin);

}  // namespace lode
