#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/delaunay/lattice_mesh.h"

namespace lode::delaunay {

/// By triangle, what is behind its edges, as LatticeTriangle::twin: found by sorting all edges by
/// their ends, whatever numbers these are. Two triangles that share an edge have it in opposite
/// directions; of edges for which that is not so some get none. O(n log n).
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> find_twins(
    std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace lode::delaunay
