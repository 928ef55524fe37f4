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

}  // namespace

std::vector<std::array<std::uint32_t, 3>> find_twins(
    std::span<const std::array<std::uint32_t, 3>> triangles) {
  std::vector<ListedEdge> edges;
  edges.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t from = triangles[t][i];
      const std::uint32_t to = triangles[t][(i + 1) % 3];
      edges.push_back(
          {std::uint64_t{std::min(from, to)} << 32 | std::max(from, to), 4 * t + i, from < to});
    }
  std::ranges::sort(edges, [](const ListedEdge& a, const ListedEdge& b) {
    return a.ends != b.ends ? a.ends < b.ends : a.half_edge < b.half_edge;
  });
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
