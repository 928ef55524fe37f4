#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/lattice_point.h"

namespace lode::terrain_lines {

/// Edges, in whatever direction and perhaps twice, joined where two that are on one line are all
/// that meet at a node, unless it is one of `kept`. All numbers are of nodes. From the smaller
/// number to the larger, sorted. O(n log n).
[[nodiscard]] std::vector<std::array<std::uint32_t, 2>> straight_runs(
    std::span<const LatticePoint> nodes, std::span<const std::array<std::uint32_t, 2>> edges,
    std::span<const std::uint32_t> kept);

}  // namespace lode::terrain_lines
