#pragma once

// What save() and open() agree on; docs/format.md, section 8.

#include <cstdint>

#include "lode/models/terrain/terrain_file/columns.h"

namespace lode::insertions {

/// Columns of numbers, each in parts of kPart.
enum class Column : std::uint32_t {
  x = 1,        ///< int32 by vertex.
  y = 2,        ///< int32 by vertex.
  height = 3,   ///< By vertex, in the type that HeightType says.
  corners = 4,  ///< uint32, three by triangle of the base.
  age = 5,      ///< uint32 by node: how many triangles were made after the one its vertex lies in.
  lines = 7,    ///< uint32, two by fixed edge of the base.
  error = 6,    ///< uint16 by triangle: the upper half of a float32.
};

enum class HeightType : std::uint8_t { int16 = 1, float32 = 2, float64 = 3 };

/// Of the metadata and the columns; files of another one are refused.
inline constexpr std::uint32_t kLayout = 3;

[[nodiscard]] inline terrain_file::ColumnKey key_of(Column column) {
  return {static_cast<std::uint32_t>(column)};
}

}  // namespace lode::insertions
