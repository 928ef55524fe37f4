#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lode/models/diamond/cell_rows.h"
#include "lode/models/diamond/edge_vertices.h"

namespace lode::diamond {

/// Where the ends of an edge are, from its anchor.
struct EdgeEnds {
  std::uint32_t place = 0;         ///< As packed_edge(), but for the anchor's x.
  std::uint32_t first_sample = 0;  ///< In samples.
  std::uint32_t second_sample = 0;
};
/// By whether the anchor's x is odd.
using EdgeEndsByParity = std::array<EdgeEnds, 2>;

/// By direction (a set of axes, 1 .. 7) less one: in the order of a row's own series.
using EdgeEndsByDirection = std::array<EdgeEndsByParity, 7>;

/// Of a row of anchors, whose y is odd with bit 0 and z with bit 1.
[[nodiscard]] const EdgeEndsByDirection& edge_ends(int parity);

/// A row of anchors, by groups of words of which the surface meets some.
template <typename T>
struct AnchorRow {
  std::span<const WordGroup> groups;
  const EdgeEndsByDirection* ends;
  std::uint32_t place;   ///< Of the anchor with x = 0.
  const T* samples;      ///< There.
  std::size_t n_bricks;  ///< Along x: as many words have a brick's row of 33 samples each, one
                         ///< brick apart; the last one's 33rd is a word of its own.
  std::uint32_t series;  ///< Bits of those that may be crossed.
};

/// The crossed edges of a row, one after the other.
template <typename T>
struct EdgeLists {
  T* first;  ///< Sample at the end with the smaller key.
  T* second;
  std::uint32_t* place;  ///< As packed_edge().
};

/// Lists the edges, direction by direction, and returns how many there are. There is room for
/// kEdgePadding more.
[[nodiscard]] std::size_t gather_edges(const AnchorRow<std::uint8_t>& row,
                                       const EdgeLists<std::uint8_t>& out);
[[nodiscard]] std::size_t gather_edges(const AnchorRow<std::uint16_t>& row,
                                       const EdgeLists<std::uint16_t>& out);
[[nodiscard]] std::size_t gather_edges(const AnchorRow<std::int16_t>& row,
                                       const EdgeLists<std::int16_t>& out);
[[nodiscard]] std::size_t gather_edges(const AnchorRow<float>& row, const EdgeLists<float>& out);
[[nodiscard]] std::size_t gather_edges(const AnchorRow<double>& row, const EdgeLists<double>& out);

}  // namespace lode::diamond
