#include "lode/api/point_terrain.h"

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "lode/api/round_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/api/terrain_tin.h"
#include "lode/core/out_of_memory.h"
#include "lode/locate/polygon_locator.h"

namespace lode {
namespace {

using delaunay_selector::PointDomain;

class PointOrigin final : public TerrainOrigin {
 public:
  explicit PointOrigin(std::shared_ptr<const PointTerrain> terrain)
      : terrain_(std::move(terrain)) {}

  [[nodiscard]] const HeightFrame& frame() const override { return terrain_->points; }
  [[nodiscard]] HeightRange range() const override { return height_range(terrain_->points); }
  [[nodiscard]] Result<SelectedTerrain> select(const TerrainOptions& options,
                                               delaunay::TinLinks links,
                                               Progress& progress) const override {
    LODE_TRY(SelectedTerrain made, select_terrain(*terrain_, options, links, progress));
    made.report.n_missing = terrain_->n_missing;
    made.report.n_left_out += terrain_->n_in_no_cell;
    return made;
  }

 private:
  std::shared_ptr<const PointTerrain> terrain_;
};

/// Of a triangle by the numbers of its points.
class PartRule {
 public:
  PartRule(const HeightPoints& points, const HorizontalMetric& metric,
           const PointTerrainOptions& options)
      : points_(points), metric_(metric), options_(options), outline_(options.outline) {}

  bool operator()(const std::array<std::uint32_t, 3>& corner) const {
    std::array<Place, 3> at;
    for (std::size_t i = 0; i < 3; ++i) {
      const LatticePoint node = points_.nodes[corner[i]];
      at[i] = points_.world(node.x, node.y);
    }
    for (std::size_t i = 0; i < 3 && options_.max_edge; ++i)
      if (metric_.distance(at[i], at[(i + 1) % 3]) > *options_.max_edge) return false;
    return options_.outline.empty() || outline_.holds((at[0] + at[1] + at[2]) * (1.0 / 3));
  }

 private:
  const HeightPoints& points_;
  const HorizontalMetric& metric_;
  const PointTerrainOptions& options_;
  PolygonLocator outline_;
};

std::vector<Vec3d> points_within(std::span<const Vec3d> points,
                                 std::span<const PlacePolygon> polygons) {
  const PolygonLocator outline(polygons);
  std::vector<Vec3d> within;
  for (const Vec3d& p : points)
    if (outline.holds({{p[0], p[1]}})) within.push_back(p);
  return within;
}

/// With polygons without jumps, and those whose longitudes are whole turns away from the points'
/// there.
PointTerrainOptions options_near(std::span<const Vec3d> points, const HorizontalMetric& metric,
                                 PointTerrainOptions options) {
  const auto middle_of = [](const auto& places) {
    const auto [west, east] = std::ranges::minmax(places, {}, [](const auto& p) { return p[0]; });
    return (west[0] + east[0]) / 2;
  };
  if (points.empty() || options.is_outline_near) return options;
  const double middle = middle_of(points);
  for (PlacePolygon& polygon : options.outline) {
    unroll_polygon(metric, polygon);
    const double shift = turns_towards(metric, middle, middle_of(polygon.front()));
    for (auto& ring : polygon)
      for (auto& p : ring) p[0] += shift;
  }
  return options;
}

Result<void> check_options(const PointTerrainOptions& options) {
  if (options.max_edge && !(*options.max_edge > 0))
    return fail("expected a longest edge > 0, got {}", *options.max_edge);
  for (const PlacePolygon& polygon : options.outline) {
    if (polygon.empty()) return fail("expected outlines with an outer ring, got none");
    for (const auto& ring : polygon)
      if (ring.size() < 3)
        return fail("expected an outline of three corners or more, got {}", ring.size());
  }
  return {};
}

}  // namespace

Terrain to_terrain(std::shared_ptr<const PointTerrain> terrain) {
  return Terrain(std::make_shared<const PointOrigin>(std::move(terrain)));
}

Result<PointTerrain> make_point_terrain(std::span<const Vec3d> points, const PointLattice& lattice,
                                        const HorizontalMetric& metric,
                                        const PointTerrainOptions& wanted, Progress& progress) try {
  LODE_CHECK(check_options(wanted));
  const PointTerrainOptions options = options_near(points, metric, wanted);
  PointTerrain made;
  std::vector<Vec3d> within;
  if (!options.outline.empty()) {
    within = points_within(points, options.outline);
    made.n_outside = points.size() - within.size();
    if (within.empty())
      return fail("expected points in the outline, got none of {}", points.size());
    points = within;
  }
  LODE_TRY(made.points, to_height_points(points, lattice, options.repeated));
  const bool is_part = options.max_edge || !options.outline.empty();
  LODE_TRY(made.domain, is_part ? delaunay_selector::find_part(
                                      made.points, PartRule(made.points, metric, options), progress)
                                : delaunay_selector::find_hull(made.points));
  return made;
} catch (const std::bad_alloc&) {
  return out_of_memory("take up the points");
}

}  // namespace lode
