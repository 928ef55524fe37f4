#include "lode/models/terrain/triangle_hierarchy/hierarchy_builder.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "lode/delaunay/tin_links.h"
#include "lode/delaunay/triangle_error.h"
#include "lode/models/terrain/triangle_hierarchy/crowded.h"

namespace lode::triangle_hierarchy {

Result<void> check_tolerances(std::span<const double> tolerances) {
  if (tolerances.empty()) return fail("levels: expected tolerances, got none");
  for (std::size_t i = 0; i < tolerances.size(); ++i) {
    if (!(tolerances[i] >= 0 && std::isfinite(tolerances[i])))
      return fail("levels: expected finite tolerances >= 0, got {}", tolerances[i]);
    if (i > 0 && tolerances[i] >= tolerances[i - 1])
      return fail("levels: expected ever smaller tolerances, got {} after {}", tolerances[i],
                  tolerances[i - 1]);
  }
  return {};
}

HierarchyBuilder::HierarchyBuilder(const ReferenceSurface& surface) : surface_(surface) {
  made_.frame = surface.frame();
  made_.is_of_points = surface.is_of_points();
  made_.bits = surface.bits();
}

std::uint32_t HierarchyBuilder::add_vertex(const Place& place, std::int32_t n_moves) {
  made_.vertices.push_back(place.at);
  made_.heights.push_back(place.height);
  n_moves_.push_back(n_moves);
  return static_cast<std::uint32_t>(made_.vertices.size() - 1);
}

Result<void> HierarchyBuilder::add_level(double tolerance, std::span<const Made> made) {
  // Half-edges are numbered in 32 bits, four a triangle.
  constexpr std::size_t kMostTriangles = (std::size_t{1} << 30) - 1;
  if (made_.triangles.size() + made.size() > kMostTriangles)
    return fail("expected up to {} triangles, got more: larger tolerances take fewer",
                kMostTriangles);
  const auto first = static_cast<std::uint32_t>(made_.triangles.size());
  for (const Made& triangle : made) {
    const auto number = static_cast<std::uint32_t>(made_.triangles.size());
    if (triangle.refined != kNone) {
      std::uint32_t& refinement = made_.triangles[triangle.refined].refinement;
      if (refinement == kNone) {
        refinement = static_cast<std::uint32_t>(made_.refinements.size());
        made_.refinements.push_back({triangle.refined, number});
      }
    }
    made_.triangles.push_back(
        {.corner = triangle.corner,
         .twin = {delaunay::kNoHalfEdge, delaunay::kNoHalfEdge, delaunay::kNoHalfEdge},
         .error = delaunay::to_float_above(triangle.sample_error + surface_.rounding())});
    errors_.push_back(triangle.error);
  }
  refine_mesh(first);
  link(first);
  made_.tolerances.push_back(tolerance);
  made_.triangles_until.push_back(static_cast<std::uint32_t>(made_.triangles.size()));
  made_.vertices_until.push_back(static_cast<std::uint32_t>(made_.vertices.size()));
  return {};
}

void HierarchyBuilder::refine_mesh(std::uint32_t first) {
  std::erase_if(mesh_, [&](std::uint32_t t) { return made_.triangles[t].refinement != kNone; });
  const std::size_t n_kept = mesh_.size();
  mesh_.resize(n_kept + made_.triangles.size() - first);
  std::iota(mesh_.begin() + static_cast<std::ptrdiff_t>(n_kept), mesh_.end(), first);
}

void HierarchyBuilder::link(std::uint32_t first) {
  std::vector<std::array<std::uint32_t, 3>> corners;
  corners.reserve(mesh_.size());
  for (const std::uint32_t t : mesh_) corners.push_back(made_.triangles[t].corner);
  const auto twins = delaunay::find_twins(corners);
  for (std::size_t i = 0; i < mesh_.size(); ++i) {
    if (mesh_[i] < first) continue;
    for (std::size_t edge = 0; edge < 3; ++edge) {
      const std::uint32_t twin = twins[i][edge];
      if (twin != delaunay::kNoHalfEdge)
        made_.triangles[mesh_[i]].twin[edge] = 4 * mesh_[twin >> 2] + (twin & 3);
    }
  }
}

Hierarchy HierarchyBuilder::finish() {
  made_.in_rows.resize(made_.vertices.size());
  std::iota(made_.in_rows.begin(), made_.in_rows.end(), 0U);
  std::ranges::sort(made_.in_rows, {}, [&](std::uint32_t v) {
    return std::tuple(made_.vertices[v].y, made_.vertices[v].x);
  });
  // Half a node each, and one for good measure.
  for (const std::int32_t n : n_moves_) made_.reach = std::max(made_.reach, n / 2 + 1);
  if (made_.is_of_points) made_.crowded = find_crowded(made_, surface_);
  return std::move(made_);
}

}  // namespace lode::triangle_hierarchy
