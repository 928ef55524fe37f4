#include "lode/mappers/vertex_corners.h"

namespace lode {
namespace {

template <std::size_t N>
VertexCorners sort_corners(std::span<const std::array<std::uint32_t, N>> simplices,
                           std::size_t n_vertices) {
  VertexCorners result;
  result.first.assign(n_vertices + 1, 0);
  result.corners.resize(N * simplices.size());
  for (const auto& simplex : simplices)
    for (const std::uint32_t vertex : simplex) ++result.first[vertex];
  std::uint32_t end = 0;
  for (std::uint32_t& offset : result.first) offset = end += offset;
  // Filling backwards turns each group's end into its start, and keeps corners ascending.
  for (std::size_t s = simplices.size(); s-- > 0;)
    for (std::size_t k = N; k-- > 0;)
      result.corners[--result.first[simplices[s][k]]] = static_cast<std::uint32_t>(N * s + k);
  return result;
}

}  // namespace

VertexCorners find_vertex_corners(std::span<const std::array<std::uint32_t, 3>> triangles,
                                  std::size_t n_vertices) {
  return sort_corners(triangles, n_vertices);
}

VertexCorners find_vertex_corners(std::span<const std::array<std::uint32_t, 2>> lines,
                                  std::size_t n_vertices) {
  return sort_corners(lines, n_vertices);
}

}  // namespace lode
