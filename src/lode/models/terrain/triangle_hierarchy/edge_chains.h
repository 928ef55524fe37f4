#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/flat_index.h"
#include "lode/core/result.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"

namespace lode::triangle_hierarchy {

/// What edges of a hierarchy are refined by: the vertices between their ends, in the mesh of the
/// level in which both triangles at them are replaced. Parts of a chain may have chains in turn.
class EdgeChains {
 public:
  /// By walking round what replaces each triangle. O(triangles + n log n) for n chains. Fails where
  /// that does not go round the triangle's corners, a chain has a vertex of an earlier level, or an
  /// edge with a chain is inside of what replaces its triangle, so that it is there twice.
  [[nodiscard]] static Result<EdgeChains> find_in(const Hierarchy& hierarchy);

  /// The chain of an edge from its smaller end; empty: it is never refined. O(log n).
  [[nodiscard]] std::span<const std::uint32_t> find(std::uint32_t a, std::uint32_t b) const;
  /// The ends, in this order, of the edge whose chain has this one as a part.
  [[nodiscard]] std::optional<std::array<std::uint32_t, 2>> find_whole(std::uint32_t a,
                                                                       std::uint32_t b) const;
  [[nodiscard]] std::size_t size() const { return chains_.size(); }
  [[nodiscard]] std::uint64_t n_bytes() const {
    return chains_.size() * sizeof(Chain) + vertices_.size() * sizeof(std::uint32_t) +
           wholes_.n_bytes();
  }

 private:
  struct Chain {
    std::uint64_t edge;  ///< The smaller end first.
    std::uint32_t first;
    std::uint32_t n;
  };

  /// Vertices from `from` to `to`, these not among them; at least one. Once for an edge.
  void add(std::uint32_t from, std::uint32_t to, std::span<const std::uint32_t> between);
  void sort();

  std::vector<Chain> chains_;  ///< By edge.
  std::vector<std::uint32_t> vertices_;
  FlatIndex wholes_;  ///< Chains by their parts, which go from the smaller end to the larger one.
};

}  // namespace lode::triangle_hierarchy
