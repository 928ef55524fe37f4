#pragma once

#include "lode/api/point_terrain.h"
#include "lode/api/verify_report.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"
#include "lode/models/terrain/triangle_hierarchy/patch.h"

namespace lode {

/// The Delaunay selector's mesh of a raster with features (add_lines() without breaklines) within a
/// tolerance, and the features: what triangles that are refined may begin with. Features run along
/// edges of the full TIN, so along rows, columns and diagonals. Fails as select_points() does.
[[nodiscard]] Result<triangle_hierarchy::FirstMesh> first_mesh(
    const PointTerrain& lined, const triangle_hierarchy::FineGrid& grid, double tolerance,
    Progress& progress);

/// Reports whether all lines are edges, or chains of edges on them, of the mesh of each level.
[[nodiscard]] Result<void> check_lines(const triangle_hierarchy::Hierarchy& hierarchy,
                                       Progress& progress, VerifyReport& report);

/// Reports whether a hierarchy's lines are those of a raster with features. Fails on points that
/// are not its samples.
[[nodiscard]] Result<void> compare_lines(const triangle_hierarchy::Hierarchy& hierarchy,
                                         const PointTerrain& lined, VerifyReport& report);

}  // namespace lode
