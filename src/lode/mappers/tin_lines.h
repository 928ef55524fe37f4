#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_set>

#include "lode/core/lattice_point.h"

namespace lode {

/// Edges of triangles that lines consist of.
class TinLines {
 public:
  /// `nodes`: by vertex, all different; `lines`: from node to node. Follows each from vertex to
  /// vertex that lies on it. O(triangles + edges of lines).
  TinLines(std::span<const std::array<std::uint32_t, 3>> triangles,
           std::span<const LatticePoint> nodes, std::span<const std::array<LatticePoint, 2>> lines);

  /// Of two vertices, in whatever order.
  [[nodiscard]] bool has(std::uint32_t a, std::uint32_t b) const {
    return edges_.contains(key(a, b));
  }
  /// Lines that are not all edges.
  [[nodiscard]] std::uint64_t n_broken() const { return n_broken_; }

 private:
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return a < b ? (std::uint64_t{a} << 32) | b : (std::uint64_t{b} << 32) | a;
  }

  std::unordered_set<std::uint64_t> edges_;
  std::uint64_t n_broken_ = 0;
};

}  // namespace lode
