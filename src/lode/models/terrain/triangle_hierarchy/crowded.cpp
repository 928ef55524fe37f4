#include "lode/models/terrain/triangle_hierarchy/crowded.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>

#include "lode/delaunay/lattice.h"

namespace lode::triangle_hierarchy {
namespace {

using Places = std::array<LatticePoint, 3>;

Places corners_of(const Hierarchy& hierarchy, std::uint32_t triangle) {
  const auto& [a, b, c] = hierarchy.triangles[triangle].corner;
  return {hierarchy.vertices[a], hierarchy.vertices[b], hierarchy.vertices[c]};
}

/// How far a node is to the right of a triangle's edges or out of its bounds, in columns and rows,
/// rounded up.
std::int32_t distance_out(const Places& corners, LatticePoint node) {
  const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
  const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  std::int64_t most = std::max({0, left - node.x, node.x - right, low - node.y, node.y - high});
  for (std::size_t i = 0; i < 3; ++i) {
    const LatticePoint a = corners[i];
    const LatticePoint b = corners[(i + 1) % 3];
    const std::int64_t beyond = -delaunay::doubled_area(a, b, node);
    const std::int64_t by_step =
        std::abs(std::int64_t{b.x} - a.x) + std::abs(std::int64_t{b.y} - a.y);
    if (beyond > 0) most = std::max(most, (beyond + by_step - 1) / by_step);
  }
  return static_cast<std::int32_t>(most);
}

}  // namespace

std::vector<std::uint32_t> find_crowded(const Hierarchy& hierarchy,
                                        const ReferenceSurface& surface) {
  std::vector<std::uint32_t> crowded;
  std::vector<std::uint32_t> open;
  for (std::uint32_t t = 0; t < hierarchy.triangles.size(); ++t) {
    if (hierarchy.triangles[t].refinement == kNone) continue;
    const Places corners = corners_of(hierarchy, t);
    std::int32_t reach = 0;
    open.assign(1, t);
    while (!open.empty()) {
      const std::uint32_t refinement = hierarchy.triangles[open.back()].refinement;
      open.pop_back();
      const auto [first, end] = hierarchy.triangles_of(refinement);
      for (std::uint32_t child = first; child < end; ++child) {
        for (const LatticePoint& p : corners_of(hierarchy, child))
          reach = std::max(reach, distance_out(corners, p));
        if (hierarchy.triangles[child].refinement != kNone) open.push_back(child);
      }
    }
    if (reach > 0 && surface.has_samples_beside(corners, reach)) crowded.push_back(t);
  }
  return crowded;
}

}  // namespace lode::triangle_hierarchy
