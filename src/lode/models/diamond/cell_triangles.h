#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lode/models/diamond/cell_rows.h"

namespace lode::diamond {

/// How the edges of cells whose lowest corner has one parity are numbered: all cells have 19, which
/// go by their ends as seen from the cell's corner with even coordinates. Those on the diagonals of
/// faces come last.
struct CellEdges {
  static constexpr std::size_t kEdges = 19;
  static constexpr std::size_t kCubeEdges = 13;  ///< All that the style of cubes has.

  alignas(64) std::array<std::uint32_t, 32> series{};  ///< By edge; see edge_series().
  /// By a cell's x and edge, the anchors before the edge's in their word: the anchor is at x or,
  /// for some edges, at the next x.
  alignas(64) std::array<std::array<std::uint32_t, 32>, 32> before{};
  bool is_flipped = false;  ///< Whether triangles are to be turned.
  const KuhnCubeCases* by_corners = nullptr;
};

/// By the parity and the frame, as kuhn_cube_cases() or cube_cases().
[[nodiscard]] const CellEdges& cell_edges(int parity, bool is_mirrored, SurfaceStyle style);

/// The first vertex of each own series of a row, and its first triangle.
struct RowStart {
  std::array<std::uint32_t, kOwnSeries> vertex{};
  std::uint32_t triangle = 0;
};
static_assert(sizeof(RowStart) == 32);

/// The triangles of a row of cells, and where they go.
struct CellRun {
  const CellRow* row;
  std::span<const WordGroup> groups;
  const RowStart* start;  ///< The row's and, behind it, that of the next y's,
  const RowStart* above;  ///< and of the next z's rows.
  SurfaceStyle style;
  const CellEdges* even;  ///< Of cells whose x is even,
  const CellEdges* odd;   ///< and odd.
  std::uint32_t* out;
  const std::uint32_t* end;  ///< Of what may be written, now or later.
};

void write_cells(const CellRun& run);

}  // namespace lode::diamond
