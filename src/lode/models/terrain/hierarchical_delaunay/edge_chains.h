#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/terrain/triangle_hierarchy/edge_profile.h"

namespace lode::hierarchical_delaunay {

using triangle_hierarchy::FineGrid;
using triangle_hierarchy::Place;

/// A vertex between the ends of an edge.
struct ChainPlace {
  Place place;
  std::int32_t n_moves = 0;  ///< It, or one of those that it was found between, onto the lattice.
};

/// The vertices that an edge is refined by, from a to b, until it errs by no more than the limit
/// where it crosses columns and rows, or where it does at fine nodes exactly: its worst crossing
/// splits it, and so on (D. Douglas, T. Peucker 1973). From the edge alone; backwards from b to a.
[[nodiscard]] std::vector<ChainPlace> refine_edge(const FineGrid& grid, const ChainPlace& a,
                                                  const ChainPlace& b, double limit,
                                                  triangle_hierarchy::Crossings crossings);

/// What edges between vertices are refined by, each at one level.
class EdgeChains {
 public:
  /// Vertices from `from` to `to`, these not among them; at least one. Once for an edge.
  void add(std::uint32_t from, std::uint32_t to, std::span<const std::uint32_t> between);
  /// After all are added.
  void sort();

  /// The chain of an edge from its smaller end; empty: it is never refined. O(log n).
  [[nodiscard]] std::span<const std::uint32_t> find(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] std::size_t size() const { return chains_.size(); }
  [[nodiscard]] std::uint64_t n_bytes() const {
    return chains_.size() * sizeof(Chain) + vertices_.size() * sizeof(std::uint32_t);
  }

 private:
  struct Chain {
    std::uint64_t edge;  ///< The smaller end first.
    std::uint32_t first;
    std::uint32_t n;
  };

  std::vector<Chain> chains_;  ///< By edge.
  std::vector<std::uint32_t> vertices_;
};

}  // namespace lode::hierarchical_delaunay
