#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lode/models/diamond/cell_rows.h"

namespace lode::diamond {

/// How the edges of cells whose lowest corner has one parity are numbered: all cells have 19, which
/// go by their ends as seen from the cell's corner with even coordinates.
struct CellEdges {
  static constexpr std::size_t kEdges = 19;

  alignas(64) std::array<std::uint32_t, 32> series{};  ///< By edge; see edge_series().
  std::uint32_t is_next = 0;  ///< Bit by edge: whether its anchor is the cell's next along x.
  bool is_flipped = false;    ///< Whether triangles are to be turned.
  const KuhnCubeCases* by_corners = nullptr;
};

/// By the parity and the frame, as kuhn_cube_cases().
[[nodiscard]] const CellEdges& cell_edges(int parity, bool is_mirrored);

/// The triangles of a row of cells, and where they go.
struct CellRun {
  const CellRow* row;
  std::span<const WordCells> words;
  const PerSeries* first_id;  ///< Number of the vertex at each series' first crossed anchor.
  const CellEdges* even;      ///< Of cells whose x is even,
  const CellEdges* odd;       ///< and odd.
  std::uint32_t* out;
  const std::uint32_t* end;  ///< Of what may be written, now or later.
};

void write_cells(const CellRun& run);

}  // namespace lode::diamond
