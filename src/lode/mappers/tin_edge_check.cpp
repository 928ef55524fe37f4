#include "lode/mappers/tin_edge_check.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "lode/delaunay/lattice_side.h"

namespace lode {
namespace {

using VertexTriple = std::array<std::uint32_t, 3>;

struct TinEdge {
  std::uint32_t lower, upper;
  bool is_forward;
  std::uint32_t triangle;
  std::uint32_t opposite;  ///< Vertex.
};

std::vector<TinEdge> sorted_edges(std::span<const VertexTriple> triangles) {
  std::vector<TinEdge> edges;
  edges.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = triangles[t][i];
      const std::uint32_t b = triangles[t][(i + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b, t, triangles[t][(i + 2) % 3]});
    }
  std::sort(edges.begin(), edges.end(), [](const TinEdge& a, const TinEdge& b) {
    return std::pair(a.lower, a.upper) < std::pair(b.lower, b.upper);
  });
  return edges;
}

bool is_hit(const VertexTriple& t, std::uint32_t p, std::span<const LatticePoint> nodes) {
  const auto point = [&](std::uint32_t v) { return delaunay::to_point(nodes[v]); };
  return delaunay::side_of_circle(point(t[0]), point(t[1]), point(t[2]), point(p)) > 0;
}

}  // namespace

std::vector<VertexTriple> turning_left(const Surface& surface, const HeightFrame& frame) {
  std::vector<VertexTriple> triangles = surface.triangles;
  if (frame.is_mirrored())
    for (VertexTriple& corner : triangles) std::swap(corner[1], corner[2]);
  return triangles;
}

void check_turns(std::span<const VertexTriple> triangles, std::span<const LatticePoint> nodes,
                 TinFacts& facts) {
  for (const VertexTriple& t : triangles) {
    const std::int64_t area = delaunay::doubled_area(nodes[t[0]], nodes[t[1]], nodes[t[2]]);
    facts.n_turned += static_cast<std::uint64_t>(area <= 0);
    facts.doubled_area += area;
  }
}

UncrossedLines::UncrossedLines(std::span<const VertexTriple> triangles,
                               std::span<const LatticePoint> nodes, LatticePoint last)
    : n_over_column_(static_cast<std::size_t>(last.x) + 2),
      n_over_row_(static_cast<std::size_t>(last.y) + 2) {
  // First by how much there are more than over the one before.
  const auto cover = [](std::vector<std::int64_t>& n_over, std::int32_t from, std::int32_t to) {
    if (to - from < 2) return;
    ++n_over[static_cast<std::size_t>(from) + 1];
    --n_over[static_cast<std::size_t>(to)];
  };
  for (const VertexTriple& t : triangles) {
    const auto [left, right] = std::minmax({nodes[t[0]].x, nodes[t[1]].x, nodes[t[2]].x});
    const auto [low, high] = std::minmax({nodes[t[0]].y, nodes[t[1]].y, nodes[t[2]].y});
    cover(n_over_column_, left, right);
    cover(n_over_row_, low, high);
  }
  std::partial_sum(n_over_column_.begin(), n_over_column_.end(), n_over_column_.begin());
  std::partial_sum(n_over_row_.begin(), n_over_row_.end(), n_over_row_.begin());
}

void check_edges(std::span<const VertexTriple> triangles, std::span<const LatticePoint> nodes,
                 const IsOutline& is_outline, TinFacts& facts, const IsFixed& is_fixed) {
  const std::vector<TinEdge> edges = sorted_edges(triangles);
  for (std::size_t first = 0, end = 0; first < edges.size(); first = end) {
    while (end < edges.size() && edges[end].lower == edges[first].lower &&
           edges[end].upper == edges[first].upper)
      ++end;
    ++facts.n_edges;
    const TinEdge& a = edges[first];
    if (end - first == 1) {
      ++facts.n_border_edges;
      const LatticePoint p = nodes[a.is_forward ? a.lower : a.upper];
      const LatticePoint q = nodes[a.is_forward ? a.upper : a.lower];
      facts.n_off_outline += static_cast<std::uint64_t>(!is_outline(p, q));
    } else if (end - first > 2 || a.is_forward == edges[first + 1].is_forward) {
      ++facts.n_overused;
    } else {
      ++facts.n_inner_edges;
      if (!is_hit(triangles[a.triangle], edges[first + 1].opposite, nodes)) continue;
      ++(is_fixed && is_fixed(a.lower, a.upper) ? facts.n_constrained : facts.n_not_delaunay);
    }
  }
}

}  // namespace lode
