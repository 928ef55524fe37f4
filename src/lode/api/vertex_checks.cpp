#include "lode/api/vertex_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

namespace lode {
namespace {

/// A line's edge, from the end that is first in rows on.
using FixedEdge = std::array<std::pair<std::int32_t, std::int32_t>, 2>;

FixedEdge fixed_edge(LatticePoint a, LatticePoint b) {
  FixedEdge edge{std::pair(a.y, a.x), std::pair(b.y, b.x)};
  std::ranges::sort(edge);
  return edge;
}

}  // namespace

void check_vertices(std::span<const LatticePoint> vertices, std::span<const double> heights,
                    const HeightGrid& grid, VerifyReport& report) {
  std::uint64_t n_other = 0;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const LatticePoint p = vertices[v];
    if (!grid.has_height(p.x, p.y) || grid.height(p.x, p.y) != heights[v]) ++n_other;
  }
  report.add("vertices have the samples' heights", vertices.size(), n_other,
             n_other > 0 ? fmt::format("{} have others", n_other) : "");
}

void check_vertices(std::span<const LatticePoint> vertices, std::span<const double> heights,
                    const HeightPoints& points, VerifyReport& report) {
  const auto place = [](LatticePoint p) { return std::pair(p.y, p.x); };
  std::uint64_t n_other = 0;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const LatticePoint p = vertices[v];
    const auto at = std::ranges::lower_bound(points.nodes, place(p), {}, place);
    const bool is_point = at != points.nodes.end() && *at == p;
    if (!is_point ||
        points.heights[static_cast<std::size_t>(at - points.nodes.begin())] != heights[v])
      ++n_other;
  }
  report.add("vertices have the points' heights", vertices.size(), n_other,
             n_other > 0 ? fmt::format("{} have others", n_other) : "");
}

void check_lines(std::span<const LatticePoint> vertices,
                 std::span<const std::array<std::uint32_t, 2>> lines, const PointTerrain& terrain,
                 VerifyReport& report) {
  const auto& nodes = terrain.points.nodes;
  std::map<FixedEdge, int> n_sides;
  for (const auto& [a, b] : terrain.domain.lines) n_sides[fixed_edge(nodes[a], nodes[b])] = 0;
  for (const auto& corner : terrain.domain.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto found = n_sides.find(fixed_edge(nodes[corner[i]], nodes[corner[(i + 1) % 3]]));
      if (found != n_sides.end()) ++found->second;
    }
  std::vector<FixedEdge> wanted;
  for (const auto& [edge, n] : n_sides)
    if (n == 2) wanted.push_back(edge);
  std::vector<FixedEdge> own;
  own.reserve(lines.size());
  for (const auto& [a, b] : lines) own.push_back(fixed_edge(vertices[a], vertices[b]));
  std::ranges::sort(own);
  std::vector<FixedEdge> other;
  std::ranges::set_symmetric_difference(own, wanted, std::back_inserter(other));
  report.add("fixed edges are those of the lines", wanted.size(), other.size(),
             other.empty() ? ""
                           : fmt::format("{} here, {} there, {} of one alone", own.size(),
                                         wanted.size(), other.size()));
}

}  // namespace lode
