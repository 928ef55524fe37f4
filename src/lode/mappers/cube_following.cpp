#include "lode/mappers/cube_following.h"

#include <vector>

#include "lode/mappers/cube_cases.h"

namespace lode {
namespace {

using CubeTriangle = std::array<std::uint8_t, 3>;

/// Bits: which of the six tetrahedra, chains of corners from 0 to 7, an edge belongs to.
unsigned tetrahedra_of(CellEdge edge) {
  const auto [a, b] = edge_corners(edge);
  unsigned found = 0;
  unsigned bit = 0;
  for (unsigned first = 0; first < 3; ++first)
    for (unsigned second = 0; second < 3; ++second) {
      if (second == first) continue;
      const auto is_in_chain = [&](unsigned corner) {
        return corner == 0 || corner == 7 || corner == 1U << first ||
               corner == (1U << first | 1U << second);
      };
      if (is_in_chain(a) && is_in_chain(b)) found |= 1U << bit;
      ++bit;
    }
  return found;
}

/// Vertices that two triangles have in common.
std::vector<std::uint8_t> common_of(const CubeTriangle& s, const CubeTriangle& t) {
  std::vector<std::uint8_t> common;
  for (const std::uint8_t v : s)
    if (v == t[0] || v == t[1] || v == t[2]) common.push_back(v);
  return common;
}

CubeFollowing find_following(unsigned corners) {
  const KuhnCubeCase& c = cube_cases(0, false)[corners];
  const bool is_annulus = c.n_edges == c.n_triangles;
  if (c.n_triangles == 0 || is_annulus || needs_body_vertex(corners)) return {};
  std::array<unsigned, 19> tetrahedra{};
  for (std::size_t e = 0; e < c.n_edges; ++e) tetrahedra[e] = tetrahedra_of(c.edges[e]);
  std::vector<CubeTriangle> between;  // ends of triangles' common edges that are in no tetrahedron
  std::vector<CubeTriangle> whole;    // triangles that are in none
  for (std::size_t t = 0; t < c.n_triangles; ++t) {
    const CubeTriangle& v = c.triangles[t];
    if ((tetrahedra[v[0]] & tetrahedra[v[1]] & tetrahedra[v[2]]) == 0) whole.push_back(v);
    for (std::size_t s = 0; s < t; ++s) {
      const auto ends = common_of(c.triangles[s], v);
      if (ends.size() == 2 && (tetrahedra[ends[0]] & tetrahedra[ends[1]]) == 0)
        between.push_back({ends[0], ends[1], 0});
    }
  }
  using Body = CubeFollowing::Body;
  const bool has_body_vertex = (corners & 1) != (corners >> 7 & 1);
  if (!has_body_vertex) return {between.empty() ? Body::none : Body::unknown, {}};
  if (between.size() == 1) return {Body::on_edge, between.front()};
  if (between.empty() && whole.size() == 1) return {Body::in_triangle, whole.front()};
  return {};
}

}  // namespace

const CubeFollowing& cube_following(unsigned corners) {
  static const std::array<CubeFollowing, 256> kTable = [] {
    std::array<CubeFollowing, 256> all;
    for (unsigned i = 0; i < 256; ++i) all[i] = find_following(i);
    return all;
  }();
  return kTable[corners];
}

}  // namespace lode
