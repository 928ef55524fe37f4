#include "lode/delaunay/tin_links.h"

#include <algorithm>

namespace lode::delaunay {
namespace {

/// An edge of a triangle, by its ends whatever their order.
struct ListedEdge {
  std::uint64_t ends;
  std::uint32_t half_edge;  ///< 4 times the triangle, and its edge.
  bool is_rising;           ///< From the smaller end.
};

using Triangles = std::span<const std::array<std::uint32_t, 3>>;

template <typename Visit>
void for_each_edge(Triangles triangles, const Visit& visit) {
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t from = triangles[t][i];
      const std::uint32_t to = triangles[t][(i + 1) % 3];
      visit(ListedEdge{std::uint64_t{std::min(from, to)} << 32 | std::max(from, to), 4 * t + i,
                       from < to});
    }
}

bool is_before(const ListedEdge& a, const ListedEdge& b) {
  return a.ends != b.ends ? a.ends < b.ends : a.half_edge < b.half_edge;
}

/// In order, of corners up to `last`: edges are put where those of their smaller end go, a few
/// each, and only these are sorted.
std::vector<ListedEdge> list_dense(Triangles triangles, std::uint32_t last) {
  std::vector<std::size_t> first(std::size_t{last} + 2);
  for_each_edge(triangles, [&](const ListedEdge& edge) { ++first[(edge.ends >> 32) + 1]; });
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  std::vector<ListedEdge> edges(3 * triangles.size());
  for_each_edge(triangles, [&](const ListedEdge& edge) { edges[next[edge.ends >> 32]++] = edge; });
  for (std::size_t v = 0; v + 1 < first.size(); ++v)
    std::sort(&edges[0] + first[v], &edges[0] + first[v + 1], is_before);
  return edges;
}

std::vector<ListedEdge> list_edges(Triangles triangles) {
  std::uint32_t last = 0;
  for (const auto& triangle : triangles) last = std::max(last, std::ranges::max(triangle));
  if (!triangles.empty() && last / 8 < triangles.size()) return list_dense(triangles, last);
  std::vector<ListedEdge> edges;
  edges.reserve(3 * triangles.size());
  for_each_edge(triangles, [&](const ListedEdge& edge) { edges.push_back(edge); });
  std::ranges::sort(edges, is_before);
  return edges;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> find_twins(
    std::span<const std::array<std::uint32_t, 3>> triangles) {
  const std::vector<ListedEdge> edges = list_edges(triangles);
  std::vector<std::array<std::uint32_t, 3>> twins(triangles.size(),
                                                  {kNoHalfEdge, kNoHalfEdge, kNoHalfEdge});
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const ListedEdge& a = edges[i];
    const ListedEdge& b = edges[i + 1];
    if (a.ends != b.ends || a.is_rising == b.is_rising) continue;
    twins[a.half_edge / 4][a.half_edge % 4] = b.half_edge;
    twins[b.half_edge / 4][b.half_edge % 4] = a.half_edge;
    ++i;
  }
  return twins;
}

}  // namespace lode::delaunay
