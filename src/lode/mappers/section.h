#pragma once

#include "lode/core/mesh.h"
#include "lode/core/surface.h"
#include "lode/mappers/lattice_frame.h"

namespace lode {

struct SectionPlane {
  Vec3d point;   ///< World.
  Vec3d normal;  ///< Any length but zero.
};

/// Mesh vertices at most so far from a plane of this normal count as in it: as far as isosurface
/// vertices keep from the ends of their edges (LatticeFrame::margin), along each axis.
[[nodiscard]] double snap_distance(const LatticeFrame& frame, const Vec3d& normal);

/// What a plane cuts out of a mesh of tetrahedra: triangles, counter-clockwise seen from where the
/// normal points to, with the field's value at each vertex and the cell's error on each triangle.
/// Where the plane passes through mesh vertices these are the section's, with their own values, and
/// where it holds faces of the mesh these are its triangles, once each and with the smaller error
/// of the two cells: also at the mesh's border, whichever side the mesh is on. Within
/// snap_distance() of a vertex the section bends to it. Values are the field's before positions are
/// rounded to float32. O(cells).
[[nodiscard]] Surface cut_section(const SimplexMesh& mesh, const SectionPlane& plane,
                                  const LatticeFrame& frame);

/// Appends the lines where a section's field is the isovalue, with lower values on the right as
/// seen from where the normal points to; `value >= isovalue` is inside. Ends of lines keep away
/// from the section's vertices by the frame's margin, or a quarter of their edge. Returns the
/// largest error of a triangle that has a line.
double add_isolines(const Surface& section, double isovalue, const LatticeFrame& frame,
                    Surface& lines);

}  // namespace lode
