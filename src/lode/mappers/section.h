#pragma once

#include "lode/core/mesh.h"
#include "lode/core/surface.h"
#include "lode/mappers/lattice_frame.h"

namespace lode {

struct SectionPlane {
  Vec3d point;   ///< World.
  Vec3d normal;  ///< Any length but zero.
};

/// What makes positions of a section float32.
struct SectionRounding {
  Vec3d origin;       ///< What positions are relative to.
  double snap = 0;    ///< Mesh vertices at most so far from the plane count as in it; world units.
  double margin = 0;  ///< How far ends of isolines keep from the section's vertices; world units.
};

/// As far from a plane of this normal as isosurface vertices keep from the ends of their edges
/// (LatticeFrame::margin), along each axis.
[[nodiscard]] SectionRounding section_rounding(const LatticeFrame& frame, const Vec3d& normal);
/// The same where these keep `margin` (rounding_margin()) away.
[[nodiscard]] SectionRounding section_rounding(const Vec3d& origin, double margin,
                                               const Vec3d& normal);

/// What a plane cuts out of a mesh of tetrahedra: triangles, counter-clockwise seen from where the
/// normal points to, with the field's value and attributes at each vertex and the cell's error and
/// region on each triangle. Where the plane passes through mesh vertices these are the section's,
/// with their own values, and where it holds faces of the mesh these are its triangles, once each
/// and with the smaller error of the two cells: also at the mesh's border, whichever side the mesh
/// is on. Within rounding.snap of a vertex the section bends to it. Values are the field's before
/// positions are rounded to float32. O(cells).
[[nodiscard]] Surface cut_section(const SimplexMesh& mesh, const SectionPlane& plane,
                                  const SectionRounding& rounding);

/// Appends the lines where a section's field is the isovalue, with its attributes, with lower
/// values on the right as seen from where the normal points to; `value >= isovalue` is inside. Ends
/// of lines keep away from the section's vertices by `margin` (world units), or a quarter of their
/// edge. Returns the largest error of a triangle that has a line.
double add_isolines(const Surface& section, double isovalue, double margin, Surface& lines);

}  // namespace lode
