#include "lode/models/terrain/triangle_hierarchy/polygon.h"

#include <utility>

#include "lode/delaunay/triangulation.h"

namespace lode::triangle_hierarchy {

Result<Patch> triangulate_polygon(std::vector<Place> corners) {
  Patch made{.places = std::move(corners), .triangles = {}};
  const auto n = static_cast<std::uint32_t>(made.places.size());
  if (n == 3) {
    made.triangles.push_back({0, 1, 2});
    return made;
  }
  std::vector<delaunay::Point> points;
  std::vector<std::array<std::uint32_t, 2>> sides;
  for (std::uint32_t i = 0; i < n; ++i) {
    const delaunay::LatticePoint at = made.places[i].at;
    points.push_back({{static_cast<double>(at.x), static_cast<double>(at.y)}});
    sides.push_back({i, (i + 1) % n});
  }
  LODE_TRY(made.triangles, delaunay::triangulate_region(std::move(points), sides));
  // A triangulation of one polygon, and of nothing else.
  if (made.triangles.size() != n - 2)
    return fail("expected a polygon that turns left once round, got another");
  return made;
}

}  // namespace lode::triangle_hierarchy
