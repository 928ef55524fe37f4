#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "lode/mappers/tetrahedron_cases.h"

namespace lode {

/// The cell of an isosurface in one simplex. Bit i of `inside`: value i is at least the isovalue;
/// neither none nor all. vertex_on(i, j) gives the vertex on an edge, put(cell) takes the result.
/// With `flip`, cells are turned round: for negatively oriented simplices, or mirrored frames.
template <int D, typename VertexOn, typename Put>
void march_simplex(std::size_t inside, bool flip, const VertexOn& vertex_on, const Put& put) {
  if constexpr (D == 3) {
    const auto& o = kTetrahedronOrder[inside];
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      put(std::array{a, flip ? c : b, flip ? b : c});
    };
    const int n_inside = std::popcount(inside);
    if (n_inside == 2) {
      const std::uint32_t ik = vertex_on(o[0], o[2]);
      const std::uint32_t il = vertex_on(o[0], o[3]);
      const std::uint32_t jl = vertex_on(o[1], o[3]);
      const std::uint32_t jk = vertex_on(o[1], o[2]);
      add(ik, il, jl);
      add(ik, jl, jk);
      return;
    }
    const std::uint32_t ij = vertex_on(o[0], o[1]);
    const std::uint32_t ik = vertex_on(o[0], o[2]);
    const std::uint32_t il = vertex_on(o[0], o[3]);
    if (n_inside == 1)
      add(ij, ik, il);
    else
      add(ij, il, ik);
  } else {
    const bool is_single_inside = std::has_single_bit(inside);
    const auto single = static_cast<std::size_t>(
        std::countr_zero(is_single_inside ? inside : std::size_t{7} - inside));
    std::uint32_t from = vertex_on(single, (single + 1) % 3);
    std::uint32_t to = vertex_on(single, (single + 2) % 3);
    if (flip != !is_single_inside) std::swap(from, to);
    put(std::array{from, to});
  }
}

}  // namespace lode
