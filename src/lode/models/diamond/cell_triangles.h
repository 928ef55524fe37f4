#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lode/models/diamond/cell_edges.h"
#include "lode/models/diamond/cell_rows.h"

namespace lode::diamond {

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
