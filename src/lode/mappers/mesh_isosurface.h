#pragma once

#include <span>

#include "lode/core/mesh.h"
#include "lode/core/parallel.h"
#include "lode/core/surface.h"

namespace lode {

struct MeshIsosurfaceOptions {
  /// How far vertices keep away from the ends of their edges, world units, but at most a quarter of
  /// the edge: rounding_margin(), so that rounding to float32 makes no two of them one.
  double margin = 0;
  bool with_isovalues = true;  ///< By vertex.
  /// By vertex of the mesh: gives vertices normals, that are turned to lower values; zero where
  /// gradients cancel (see fill_zero_normals()). Empty: no normals.
  std::span<const Vec3f> gradients{};
  Threads threads{};
};

/// Appends the triangles where the field of a mesh of tetrahedra is the isovalue, counter-clockwise
/// seen from lower values; `value >= isovalue` is inside. Vertices, one for each edge that is
/// crossed, have positions relative to surface.origin, the isovalue, and normals, linear along the
/// edge and then of unit length, where gradients are given, and the mesh's attributes, linear along
/// the edge; triangles the regions of their cells. Their numbers and the order of triangles do not
/// depend on the threads; what a cell's triangles are depends neither on other cells, nor on the
/// order of cells, vertices or corners, but for which way the cell is turned. Returns the largest
/// error of a cell that is crossed. O(cells); takes a byte a vertex, and for a while 24 bytes a
/// triangle.
double add_isosurface(const SimplexMesh& mesh, double isovalue,
                      const MeshIsosurfaceOptions& options, Surface& surface);

/// Of positions relative to an origin: eight units in the last place of float32 at the largest
/// coordinate of a box round all of them.
[[nodiscard]] double rounding_margin(std::span<const Vec3d> positions, const Vec3d& origin);

}  // namespace lode
