#pragma once

// What save() and open() agree on; docs/format.md, section 8.

#include <cstdint>

#include "lode/models/terrain/terrain_file/columns.h"
#include "lode/models/terrain/terrain_file/stored_heights.h"

namespace lode::insertions {

/// Columns of numbers, each in parts of kPart, but for pages.
enum class Column : std::uint32_t {
  x = 1,        ///< int32 by vertex of the base.
  y = 2,        ///< int32 by vertex of the base.
  height = 3,   ///< By vertex of the base, in the type that HeightType says.
  corners = 4,  ///< uint32, three by triangle of the base.
  steps = 5,    ///< uint32: errors of all steps, their times, triangles and largest errors.
  error = 6,    ///< uint16 by triangle of the base: the upper half of a float32.
  lines = 7,    ///< uint32, two by fixed edge of the base.
  boxes = 8,    ///< int32: first columns of all pages, first rows, last columns, last rows.
  counts = 9,   ///< uint32: nodes of all pages, then triangles that these make.
  nodes = 10,   ///< Bits, by page: a block each, of any size.
  made = 11,    ///< uint16 by triangle that a page's nodes make: its error. A block a page.
};

using HeightType = terrain_file::StoredHeight;

/// Of the metadata and the columns; files of another one are refused.
inline constexpr std::uint32_t kLayout = 4;

[[nodiscard]] inline terrain_file::ColumnKey key_of(Column column) {
  return {static_cast<std::uint32_t>(column)};
}

/// Of Column::nodes and Column::made.
[[nodiscard]] inline store::BlockKey key_of(Column column, std::uint32_t page) {
  return {static_cast<std::uint32_t>(column), 0, {{static_cast<std::int32_t>(page), 0, 0}}};
}

}  // namespace lode::insertions
