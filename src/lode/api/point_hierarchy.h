#pragma once

#include <memory>

#include "lode/api/point_terrain.h"
#include "lode/api/verify_report.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"
#include "lode/models/terrain/triangle_hierarchy/point_surface.h"

namespace lode {

/// The triangulation of all points of a terrain, with its lines as edges. Fails on heights beyond
/// what delaunay::check_heights() takes, and when cancelled.
[[nodiscard]] Result<std::unique_ptr<const triangle_hierarchy::PointSurface>> surface_of(
    const PointTerrain& terrain, Progress& progress);

/// Holds all levels of a hierarchy against the points it was built of: that vertices are on the
/// triangulation of all points, the domain, the error of every point, and what triangles say of it;
/// by other means than it was made, but for that triangulation.
[[nodiscard]] Result<void> check_against_points(const triangle_hierarchy::Hierarchy& hierarchy,
                                                const PointTerrain& terrain, Threads threads,
                                                Progress& progress, VerifyReport& report);

}  // namespace lode
