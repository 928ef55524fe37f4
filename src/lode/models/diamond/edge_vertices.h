#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "lode/core/vec.h"
#include "lode/mappers/lattice_frame.h"

namespace lode::diamond {

/// Crossed edges of the finest lattice whose anchors (lowest corners) lie in some rows (y, z), by
/// their ends: the first is the one with the smaller key. There is room for kEdgePadding more.
template <typename T>
struct EdgeRun {
  const T* first;  ///< Sample there.
  const T* second;
  const std::uint32_t* place;  ///< Of the first end, as packed_edge().
  std::size_t n;
};

/// What vectors may read or write behind the last edge.
inline constexpr std::size_t kEdgePadding = 64;

/// How many rows of anchors, one above the other in y, a run may be of.
inline constexpr std::int32_t kRowsPerRun = 16;

/// The x of an edge's first end; the row of anchors, and whether that end lies one up in y, added
/// up; whether it lies one up in z; the step to the second end along each axis, -1 .. 1.
struct PackedEdge {
  static constexpr std::uint32_t kX = 0xFFFFF;
  static constexpr int kRowShift = 20;
  static constexpr std::uint32_t kRow = std::uint32_t{2} * kRowsPerRun - 1;
  static constexpr int kUpShift = 25;  ///< In z.
  static constexpr int kStepShift = 26;
};
static_assert(PackedEdge::kRowShift + std::bit_width(PackedEdge::kRow) == PackedEdge::kUpShift);

/// In the first row of anchors.
[[nodiscard]] constexpr std::uint32_t packed_edge(std::int32_t x, const Vec<std::int32_t, 3>& up,
                                                  const Vec<std::int32_t, 3>& step) {
  std::uint32_t edge = static_cast<std::uint32_t>(x) |
                       static_cast<std::uint32_t>(up[1]) << PackedEdge::kRowShift |
                       static_cast<std::uint32_t>(up[2]) << PackedEdge::kUpShift;
  for (std::size_t i = 0; i < 3; ++i)
    edge |= (static_cast<std::uint32_t>(step[i]) & 3U)
            << (PackedEdge::kStepShift + 2 * static_cast<int>(i));
  return edge;
}

/// The ends of such an edge, in a run of which this is the first row of anchors.
[[nodiscard]] constexpr std::array<Vec<std::int32_t, 3>, 2> unpacked_edge(std::uint32_t edge,
                                                                          std::int32_t y,
                                                                          std::int32_t z) {
  const Vec<std::int32_t, 3> p{
      {static_cast<std::int32_t>(edge & PackedEdge::kX),
       y + static_cast<std::int32_t>(edge >> PackedEdge::kRowShift & PackedEdge::kRow),
       z + static_cast<std::int32_t>(edge >> PackedEdge::kUpShift & 1U)}};
  Vec<std::int32_t, 3> step;
  for (std::size_t i = 0; i < 3; ++i)
    step[i] = static_cast<std::int32_t>(edge << (4 - 2 * static_cast<int>(i))) >> 30;
  return {p, p + step};
}

/// Where vertices on the edges of a run go.
struct VertexRun {
  const LatticeFrame* frame;
  double isovalue;
  std::int32_t y, z;       ///< Of the first row of anchors.
  Vec3f* positions;        ///< Of the first edge's vertex,
  const Vec3f* end;        ///< and of what may be written, now or later.
  double* kept = nullptr;  ///< Edge parameters, with padding, where they are wanted.
};

/// What rounding is derived from.
struct EdgeExtremes {
  double largest_step = 0;  ///< Largest difference of values along a crossed edge.
  double largest_snap = 0;  ///< The same over vertices that the margin moved.
};

/// Writes the positions of the vertices on the edges, and raises the extremes: as crossing() and
/// LatticeFrame::position() do one by one, to the bit. Bound by the division.
void place_vertices(const EdgeRun<std::uint8_t>& run, const VertexRun& to, EdgeExtremes& extremes);
void place_vertices(const EdgeRun<std::uint16_t>& run, const VertexRun& to, EdgeExtremes& extremes);
void place_vertices(const EdgeRun<std::int16_t>& run, const VertexRun& to, EdgeExtremes& extremes);
void place_vertices(const EdgeRun<float>& run, const VertexRun& to, EdgeExtremes& extremes);
void place_vertices(const EdgeRun<double>& run, const VertexRun& to, EdgeExtremes& extremes);

}  // namespace lode::diamond
