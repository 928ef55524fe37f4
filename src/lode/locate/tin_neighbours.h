#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/delaunay/tin.h"

namespace lode {

/// A triangle and how many steps across edges it takes to get there.
struct RingTriangle {
  std::uint32_t triangle = 0;
  std::uint32_t ring = 0;

  friend bool operator==(const RingTriangle&, const RingTriangle&) = default;
};

/// What lies beside the triangles of a TIN across their edges: by twins, and along edges that have
/// none all triangles with a piece of such an edge on the other side, as there are where vertices
/// hang in edges, and at both ends of what goes round. Const members are safe from many threads.
class TinNeighbours {
 public:
  struct Beside {
    std::uint32_t triangle = 0;
    std::uint32_t edge = 0;  ///< Its own, from its corner of that number to the next.

    friend bool operator==(const Beside&, const Beside&) = default;
  };

  /// The TIN, whose coordinates are below 2^30 in size, outlives it, with twins or without. With a
  /// period > 0 column 0 and that column are one place. O(n log n) and 32 bytes of edges without
  /// twins.
  explicit TinNeighbours(const delaunay::Tin& tin, std::int32_t period = 0);

  /// Behind the edge (0 to 2) of a triangle, in order along it, from its first corner; nothing
  /// where the domain ends. O(log n) and what comes out.
  [[nodiscard]] std::vector<Beside> beside(std::uint32_t triangle, std::uint32_t edge) const;

  /// Triangles at most n_rings steps from some, which are ring 0: ring by ring, each in the order
  /// of the TIN, and once.
  [[nodiscard]] std::vector<RingTriangle> rings(std::vector<std::uint32_t> start,
                                                std::uint32_t n_rings) const;

 private:
  template <typename Visit>
  void visit_beside(std::uint32_t triangle, std::uint32_t edge, const Visit& visit) const;
  /// Of an edge without a twin: the line that it lies on, the side of it that its triangle is on,
  /// and from where to where, along whichever coordinate runs.
  struct LoneEdge {
    std::int32_t dx = 0;  ///< Without common factor, dx > 0 or dx = 0 and dy = 1.
    std::int32_t dy = 0;
    std::int64_t offset = 0;
    bool is_left = false;
    std::int32_t begin = 0;
    std::int32_t end = 0;
    std::uint32_t half_edge = 0;  ///< As LatticeTriangle::twin.
  };
  [[nodiscard]] LoneEdge lone_edge(std::uint32_t triangle, std::uint32_t edge) const;

  const delaunay::Tin& tin_;
  std::int32_t period_;
  std::vector<LoneEdge> lone_;  ///< By line, side and place.
};

}  // namespace lode
