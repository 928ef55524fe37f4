#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

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

/// Crossed edges of one direction among 32 anchors of a row.
template <typename T>
struct EdgeWord {
  const T* samples;              ///< At the first anchor; that row's next 32 can be read.
  const EdgeEndsByParity* ends;  ///< Of the direction.
  std::uint32_t place;           ///< The first anchor's, whose x is even.
  std::uint32_t crossed;         ///< By bits.
  bool is_last;                  ///< One anchor alone, behind which nothing may be read.
};

/// The crossed edges of a row, one after the other.
template <typename T>
struct EdgeLists {
  T* first;  ///< Sample at the end with the smaller key.
  T* second;
  std::uint32_t* place;  ///< As packed_edge().
};

/// Lists the edges in order, and returns how many there are. There is room for kEdgePadding more.
[[nodiscard]] std::size_t gather_edges(std::span<const EdgeWord<std::uint8_t>> words,
                                       const EdgeLists<std::uint8_t>& out);
[[nodiscard]] std::size_t gather_edges(std::span<const EdgeWord<std::uint16_t>> words,
                                       const EdgeLists<std::uint16_t>& out);
[[nodiscard]] std::size_t gather_edges(std::span<const EdgeWord<std::int16_t>> words,
                                       const EdgeLists<std::int16_t>& out);
[[nodiscard]] std::size_t gather_edges(std::span<const EdgeWord<float>> words,
                                       const EdgeLists<float>& out);
[[nodiscard]] std::size_t gather_edges(std::span<const EdgeWord<double>> words,
                                       const EdgeLists<double>& out);

}  // namespace lode::diamond
