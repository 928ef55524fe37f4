#pragma once

// What lies beside triangles across their edges, by trying all pairs of edges.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <queue>
#include <span>
#include <vector>

#include "lode/delaunay/tin.h"

namespace lode::test {

/// A triangle across an edge, and which of its own edges that is.
struct PairedEdge {
  std::uint32_t triangle;
  std::uint32_t edge;
  std::int64_t place;  ///< Along the edge.

  friend bool operator==(const PairedEdge&, const PairedEdge&) = default;
};
/// By triangle and edge, in order along the edge.
using EdgePairs = std::vector<std::array<std::vector<PairedEdge>, 3>>;

/// Edges that run against each other and have more than a point in common; those on the column
/// `period`, where there is one, as if they were on column 0.
inline EdgePairs pair_by_trying(const delaunay::Tin& tin, std::int32_t period = 0) {
  struct Edge {
    std::int64_t x, y, dx, dy;
    std::uint32_t triangle, edge;
  };
  std::vector<Edge> edges;
  for (std::uint32_t t = 0; t < tin.triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const auto a = tin.vertices[tin.triangles[t][i]];
      const auto b = tin.vertices[tin.triangles[t][(i + 1) % 3]];
      const bool is_last = period > 0 && a.x == period && b.x == period;
      edges.push_back({is_last ? 0 : a.x, a.y, b.x - a.x, b.y - a.y, t, i});
    }
  EdgePairs pairs(tin.triangles.size());
  for (const Edge& one : edges)
    for (const Edge& other : edges) {
      if (one.triangle == other.triangle) continue;
      if (one.dx * other.dy - one.dy * other.dx != 0) continue;
      if (one.dx * other.dx + one.dy * other.dy > 0) continue;
      const std::int64_t x = other.x - one.x;
      const std::int64_t y = other.y - one.y;
      if (one.dx * y - one.dy * x != 0) continue;
      const auto along = [&](std::int64_t u, std::int64_t v) { return u * one.dx + v * one.dy; };
      const std::int64_t end = along(x, y);
      const std::int64_t begin = along(x + other.dx, y + other.dy);
      if (std::max<std::int64_t>(begin, 0) < std::min(end, along(one.dx, one.dy)))
        pairs[one.triangle][one.edge].push_back({other.triangle, other.edge, begin});
    }
  for (auto& of_triangle : pairs)
    for (auto& of_edge : of_triangle) std::ranges::sort(of_edge, {}, &PairedEdge::place);
  return pairs;
}

/// By triangle the fewest steps from some, or the largest number.
inline std::vector<std::uint32_t> steps_from(const EdgePairs& pairs,
                                             std::span<const std::uint32_t> start) {
  constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> steps(pairs.size(), kNever);
  std::queue<std::uint32_t> waiting;
  for (const std::uint32_t t : start) {
    steps[t] = 0;
    waiting.push(t);
  }
  for (; !waiting.empty(); waiting.pop())
    for (const auto& of_edge : pairs[waiting.front()])
      for (const PairedEdge& one : of_edge)
        if (steps[one.triangle] == kNever) {
          steps[one.triangle] = steps[waiting.front()] + 1;
          waiting.push(one.triangle);
        }
  return steps;
}

}  // namespace lode::test
