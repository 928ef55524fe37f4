#pragma once

#include "lode/api/point_terrain.h"
#include "lode/api/verify_report.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"
#include "lode/models/terrain/triangle_hierarchy/patch.h"
#include "lode/models/terrain/triangle_hierarchy/reference_surface.h"

namespace lode {

/// The Delaunay selector's mesh of points within a tolerance, and their lines: what triangles that
/// are refined may begin with. Of a raster they are its samples, with features (add_lines() without
/// breaklines), which run along edges of the full TIN, so along rows, columns and diagonals. Fails
/// as select_points() does.
[[nodiscard]] Result<triangle_hierarchy::FirstMesh> first_mesh(
    const PointTerrain& lined, const triangle_hierarchy::ReferenceSurface& surface,
    double tolerance, Progress& progress);

/// Reports whether all lines are edges, or chains of edges on them, of the mesh of each level.
[[nodiscard]] Result<void> check_lines(const triangle_hierarchy::Hierarchy& hierarchy,
                                       Progress& progress, VerifyReport& report);

/// Reports whether a hierarchy's lines are those of points, or of a raster with features. Fails on
/// points of another lattice.
[[nodiscard]] Result<void> compare_lines(const triangle_hierarchy::Hierarchy& hierarchy,
                                         const PointTerrain& lined, VerifyReport& report);

}  // namespace lode
