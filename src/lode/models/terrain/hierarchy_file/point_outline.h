#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/result.h"
#include "lode/delaunay/lattice.h"

namespace lode::hierarchy_file {

/// From node to node, in whatever direction; what is inside is on the left.
using OutlineEdge = std::array<delaunay::LatticePoint, 2>;

/// Edges in order, with those joined that go straight on at a node where no others are: so equal
/// for equal outlines, however these are cut. O(n log n).
[[nodiscard]] std::vector<OutlineEdge> join_edges(std::vector<OutlineEdge> edges);

/// Fails where edges cross or overlap, or do not go round what is inside once. Also where more than
/// kMostEdgesAtNode of them meet, as it takes time by the square of that. O(n log n) usually.
[[nodiscard]] Result<void> check_goes_round_once(const std::vector<OutlineEdge>& outline);

inline constexpr std::uint32_t kMostEdgesAtNode = 8192;

}  // namespace lode::hierarchy_file
