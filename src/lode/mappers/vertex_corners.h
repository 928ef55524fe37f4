#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lode {

/// Which simplices use a vertex: corner k of simplex s is number N·s + k; the corners of a vertex
/// lie together, ascending. 4 bytes a corner and a vertex.
struct VertexCorners {
  std::vector<std::uint32_t> first;  ///< n_vertices + 1 offsets into corners.
  std::vector<std::uint32_t> corners;

  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t vertex) const {
    return std::span(corners).subspan(first[vertex], first[vertex + 1] - first[vertex]);
  }
};

/// Counting sort of all corners by vertex; indices must be below n_vertices.
[[nodiscard]] VertexCorners find_vertex_corners(
    std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t n_vertices);
[[nodiscard]] VertexCorners find_vertex_corners(std::span<const std::array<std::uint32_t, 2>> lines,
                                                std::size_t n_vertices);

}  // namespace lode
