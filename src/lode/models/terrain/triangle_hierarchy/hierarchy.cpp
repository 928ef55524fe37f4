#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"

#include <algorithm>

#include "lode/delaunay/tin_links.h"

namespace lode::triangle_hierarchy {
namespace {

struct Bounds {
  LatticePoint lower;
  LatticePoint upper;

  void join(const Bounds& other) {
    lower = {std::min(lower.x, other.lower.x), std::min(lower.y, other.lower.y)};
    upper = {std::max(upper.x, other.upper.x), std::max(upper.y, other.upper.y)};
  }
  [[nodiscard]] bool holds(const Bounds& other, std::int32_t reach) const {
    return other.lower.x >= lower.x - reach && other.lower.y >= lower.y - reach &&
           other.upper.x <= upper.x + reach && other.upper.y <= upper.y + reach;
  }
};

Bounds bounds_of(const Hierarchy& hierarchy, std::uint32_t triangle) {
  const auto& corner = hierarchy.triangles[triangle].corner;
  Bounds bounds{hierarchy.vertices[corner[0]], hierarchy.vertices[corner[0]]};
  for (const std::uint32_t vertex : corner)
    bounds.join({hierarchy.vertices[vertex], hierarchy.vertices[vertex]});
  return bounds;
}

}  // namespace

std::uint64_t Hierarchy::n_bytes() const {
  return vertices.size() * (sizeof(vertices[0]) + sizeof(heights[0]) + sizeof(in_rows[0])) +
         triangles.size() * sizeof(triangles[0]) + refinements.size() * sizeof(refinements[0]) +
         lines.size() * sizeof(lines[0]) + crowded.size() * sizeof(crowded[0]) +
         tolerances.size() * (sizeof(tolerances[0]) + 2 * sizeof(vertices_until[0]));
}

std::array<std::uint32_t, 2> Hierarchy::triangles_of(std::uint32_t refinement) const {
  const std::size_t next = std::size_t{refinement} + 1;
  const std::uint32_t end = next < refinements.size()
                                ? refinements[next].first
                                : static_cast<std::uint32_t>(triangles.size());
  return {refinements[refinement].first, end};
}

std::uint64_t Hierarchy::n_triangles_in(int level) const {
  const std::uint32_t end = triangles_until[static_cast<std::size_t>(level)];
  const auto later = std::ranges::lower_bound(refinements, end, {}, &Refinement::first);
  return end - static_cast<std::uint64_t>(later - refinements.begin());
}

Result<int> Hierarchy::level_within(double tolerance) const {
  const auto found = std::ranges::find_if(tolerances, [&](double t) { return t <= tolerance; });
  if (found == tolerances.end())
    return fail("expected a tolerance that a level keeps, {} or more, got {}", tolerances.back(),
                tolerance);
  return static_cast<int>(found - tolerances.begin());
}

std::uint32_t Hierarchy::neighbour(int level, std::uint32_t triangle, unsigned edge) const {
  std::uint32_t twin = triangles[triangle].twin[edge];
  if (twin == delaunay::kNoHalfEdge) return twin;
  const std::uint32_t from = triangles[triangle].corner[(edge + 1) % 3];
  const std::uint32_t to = triangles[triangle].corner[edge];
  while (!is_in_level(twin >> 2, level)) {
    // The edge is whole, so one of the smaller triangles has it.
    const auto [first, end] = triangles_of(triangles[twin >> 2].refinement);
    twin = delaunay::kNoHalfEdge;
    for (std::uint32_t t = first; t < end && twin == delaunay::kNoHalfEdge; ++t)
      for (unsigned i = 0; i < 3; ++i)
        if (triangles[t].corner[i] == from && triangles[t].corner[(i + 1) % 3] == to)
          twin = 4 * t + i;
    if (twin == delaunay::kNoHalfEdge) return twin;
  }
  return twin;
}

std::uint64_t n_out_of_reach(const Hierarchy& hierarchy) {
  std::uint64_t n = 0;
  std::vector<Bounds> all;  // By triangle, with all that refines it.
  all.reserve(hierarchy.triangles.size());
  for (std::uint32_t t = 0; t < hierarchy.triangles.size(); ++t)
    all.push_back(bounds_of(hierarchy, t));
  // Later ones refine none before them.
  for (auto r = static_cast<std::uint32_t>(hierarchy.refinements.size()); r-- > 0;) {
    const auto [first, end] = hierarchy.triangles_of(r);
    Bounds parts = all[first];
    for (std::uint32_t t = first + 1; t < end; ++t) parts.join(all[t]);
    const std::uint32_t refined = hierarchy.refinements[r].triangle;
    n += static_cast<std::uint64_t>(!all[refined].holds(parts, hierarchy.reach));
    all[refined].join(parts);
  }
  return n;
}

void place_vertices(const Hierarchy& hierarchy, delaunay::Tin& tin) {
  std::vector<std::uint32_t> number(hierarchy.vertices.size(), kNone);
  for (const auto& corners : tin.triangles)
    for (const std::uint32_t vertex : corners) number[vertex] = 0;
  for (const std::uint32_t vertex : hierarchy.in_rows) {
    if (number[vertex] == kNone) continue;
    number[vertex] = static_cast<std::uint32_t>(tin.vertices.size());
    tin.vertices.push_back(hierarchy.vertices[vertex]);
    tin.heights.push_back(hierarchy.heights[vertex]);
  }
  for (auto& corners : tin.triangles)
    for (std::uint32_t& vertex : corners) vertex = number[vertex];
}

delaunay::Tin tin_of_level(const Hierarchy& hierarchy, int level, delaunay::TinLinks links) {
  delaunay::Tin tin;
  const std::uint32_t end = hierarchy.triangles_until[static_cast<std::size_t>(level)];
  for (std::uint32_t t = 0; t < end; ++t) {
    if (!hierarchy.is_in_level(t, level)) continue;
    tin.triangles.push_back(hierarchy.triangles[t].corner);
    if (links == delaunay::TinLinks::kept) tin.errors.push_back(hierarchy.triangles[t].error);
  }
  place_vertices(hierarchy, tin);
  if (links == delaunay::TinLinks::kept) tin.twins = delaunay::find_twins(tin.triangles);
  return tin;
}

}  // namespace lode::triangle_hierarchy
