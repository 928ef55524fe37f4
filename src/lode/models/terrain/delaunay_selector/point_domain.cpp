#include "lode/models/terrain/delaunay_selector/point_domain.h"

#include <span>
#include <utility>

#include "lode/delaunay/convex_hull.h"
#include "lode/delaunay/fixed_lines.h"
#include "lode/delaunay/lattice_side.h"
#include "lode/delaunay/point_insertion.h"
#include "lode/delaunay/tin.h"
#include "lode/delaunay/tin_links.h"
#include "lode/delaunay/triangulation.h"
#include "lode/locate/tin_locator.h"

namespace lode::delaunay_selector {
namespace {

using Corners = std::array<std::uint32_t, 3>;
using Edge = std::array<std::uint32_t, 2>;

/// Finds for each point a triangle that holds it.
void locate_points(const HeightPoints& points, delaunay::Tin tin, PointDomain& domain) {
  tin.twins = delaunay::find_twins(tin.triangles);
  const TinLocator locator(tin);
  domain.triangle_of.reserve(points.nodes.size());
  for (const LatticePoint& node : points.nodes) {
    const auto triangle = locator.find(delaunay::to_point(node));
    domain.triangle_of.push_back(triangle.value_or(delaunay::kNoHalfEdge));
    domain.n_left_out += static_cast<std::uint64_t>(!triangle.has_value());
  }
}

/// Of an outline of points, whose edges are by their places among the corners.
Result<PointDomain> domain_within(const HeightPoints& points,
                                  std::span<const std::uint32_t> corners,
                                  std::span<const Edge> edges) {
  delaunay::Tin tin;
  std::vector<delaunay::Point> places;
  for (const std::uint32_t corner : corners) {
    tin.vertices.push_back(points.nodes[corner]);
    places.push_back(delaunay::to_point(points.nodes[corner]));
  }
  LODE_TRY(tin.triangles, delaunay::triangulate_region(std::move(places), edges));
  PointDomain domain;
  for (const Corners& t : tin.triangles)
    domain.triangles.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
  for (const Edge& edge : edges) domain.outline.push_back({corners[edge[0]], corners[edge[1]]});
  locate_points(points, std::move(tin), domain);
  return domain;
}

}  // namespace

Result<PointDomain> find_hull(const HeightPoints& points) {
  const std::vector<std::uint32_t> corners = delaunay::convex_hull(points.nodes);
  if (corners.size() < 3)
    return fail("expected at least three points that are not on one line, got {} on one",
                points.nodes.size());
  std::vector<Edge> edges;
  for (std::uint32_t i = 0; i < corners.size(); ++i)
    edges.push_back({i, i + 1 < corners.size() ? i + 1 : 0});
  return domain_within(points, corners, edges);
}

Result<LinedDomain> with_lines(const HeightPoints& points, const PointDomain& domain,
                               std::span<const Edge> lines, std::span<const std::uint32_t> single,
                               Progress& progress) {
  LODE_TRY(delaunay::FixedRegion region,
           delaunay::fix_lines(delaunay::ListedNodes(points.nodes), domain.triangles, lines, single,
                               progress));
  LinedDomain lined;
  lined.n_crossing = region.crossing.size();
  lined.line_of = std::move(region.line_of);
  PointDomain& made = lined.domain;
  made.outline = domain.outline;
  made.lines = std::move(region.edges);
  made.triangles = std::move(region.triangles);
  delaunay::Tin tin;
  std::vector<std::uint32_t> number_of(points.nodes.size(), delaunay::kNoHalfEdge);
  for (const Corners& corner : made.triangles) {
    Corners numbers{};
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& number = number_of[corner[i]];
      if (number == delaunay::kNoHalfEdge) {
        number = static_cast<std::uint32_t>(tin.vertices.size());
        tin.vertices.push_back(points.nodes[corner[i]]);
      }
      numbers[i] = number;
    }
    tin.triangles.push_back(numbers);
  }
  locate_points(points, std::move(tin), made);
  return lined;
}

Result<PointDomain> find_part(const HeightPoints& points, const KeepTriangle& keep,
                              Progress& progress) {
  LODE_TRY(const PointDomain hull, find_hull(points));
  delaunay::PointMesh mesh(delaunay::ListedNodes(points.nodes), hull.triangles);
  LODE_CHECK(delaunay::insert_all_points(mesh, {points.nodes, points.heights, hull.triangle_of},
                                         progress));
  const auto& triangles = mesh.triangles();
  std::vector<bool> is_kept;
  is_kept.reserve(triangles.size());
  for (const delaunay::LatticeTriangle& triangle : triangles)
    is_kept.push_back(keep(triangle.corner));
  constexpr std::uint32_t kNobody = delaunay::kNoHalfEdge;
  std::vector<std::uint32_t> number_of(points.nodes.size(), kNobody);
  std::vector<std::uint32_t> corners;
  const auto number = [&](std::uint32_t point) {
    if (number_of[point] == kNobody) {
      number_of[point] = static_cast<std::uint32_t>(corners.size());
      corners.push_back(point);
    }
    return number_of[point];
  };
  std::vector<Edge> edges;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t i = 0; i < 3 && is_kept[t]; ++i) {
      const std::uint32_t twin = triangles[t].twin[i];
      if (twin != kNobody && is_kept[twin / 4]) continue;
      edges.push_back({number(triangles[t].corner[i]), number(triangles[t].corner[(i + 1) % 3])});
    }
  if (edges.empty())
    return fail("expected a triangle of points in the domain, got none of {}", triangles.size());
  return domain_within(points, corners, edges);
}

}  // namespace lode::delaunay_selector
