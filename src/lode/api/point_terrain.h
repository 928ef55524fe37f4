#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "lode/api/terrain.h"
#include "lode/core/height_points.h"
#include "lode/core/horizontal_metric.h"
#include "lode/core/place_polygon.h"
#include "lode/models/terrain/delaunay_selector/point_domain.h"

namespace lode {

struct PointTerrainOptions {
  RepeatedHeights repeated = RepeatedHeights::mean;
  /// Triangles with a longer edge are no part of the domain; > 0, as the metric measures.
  std::optional<double> max_edge{};
  /// Polygons in the points' coordinates, where there are any: points outside of all are left out,
  /// and triangles whose middle is. Rings have three corners or more.
  std::vector<PlacePolygon> outline{};
  /// Whether longitudes of polygons are those of points; else whole turns bring them near.
  bool is_outline_near = false;
};

/// Scattered points, and what they define a surface over: their convex hull, or the part of their
/// Delaunay triangulation that the options leave.
struct PointTerrain {
  HeightPoints points;
  delaunay_selector::PointDomain domain;
  std::uint64_t n_outside = 0;     ///< Points outside of the outline, which are not in `points`.
  std::uint64_t n_missing = 0;     ///< Of a raster, samples without height, which are no points.
  std::uint64_t n_in_no_cell = 0;  ///< And so those in no cell with four heights.
};

/// To ask of; kept as long as that.
[[nodiscard]] Terrain to_terrain(std::shared_ptr<const PointTerrain> terrain);

/// `lattice`: see to_height_points(). Fails on points that span no area, where nothing is left of
/// the domain, on repeated points where they are refused, and when cancelled. O(n log n).
[[nodiscard]] Result<PointTerrain> make_point_terrain(std::span<const Vec3d> points,
                                                      const PointLattice& lattice,
                                                      const HorizontalMetric& metric,
                                                      const PointTerrainOptions& options,
                                                      Progress& progress);

/// As of rasters: checks that a surface is a Delaunay TIN of the points, covers exactly their
/// domain, and that no point is farther than max_error from it, by other means than it was made.
/// Of TinShape::any it need not be Delaunay.
[[nodiscard]] Result<VerifyReport> verify_terrain(const PointTerrain& terrain,
                                                  const Surface& surface,
                                                  const TerrainVerifyOptions& options,
                                                  Progress& progress);

}  // namespace lode
