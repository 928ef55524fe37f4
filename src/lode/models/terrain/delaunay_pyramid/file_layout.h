#pragma once

// What save() and PyramidFile agree on; docs/format.md, section 7.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "lode/models/terrain/terrain_file/columns.h"

namespace lode::delaunay_pyramid {

/// As the enumerators of Encoding.
inline constexpr std::array<std::string_view, 3> kModelNames{"complete_pyramid", "triangle_lists",
                                                             "linked_triangle_lists"};

/// Of the metadata and the columns; files of another one are refused.
inline constexpr std::uint32_t kLayout = 1;

/// Columns of numbers by level, but for the lines.
enum class Column : std::uint32_t {
  x = 1,             ///< int32 by vertex that the level adds.
  y = 2,             ///< The same.
  height = 3,        ///< By vertex that the level adds, in the type that the metadata say.
  corners = 4,       ///< uint32, three by triangle: vertices.
  error = 5,         ///< uint16 by triangle: the upper half of a float32.
  twins = 6,         ///< uint32, three by triangle. Of a complete pyramid.
  death = 7,         ///< uint16 by triangle: a level. Of lists.
  n_links = 8,       ///< uint32 by triangle. Where there are links.
  links = 9,         ///< uint32: those of all triangles, one after the other.
  first_links = 10,  ///< uint64 by block of `n_links`: the first link of its first triangle.
  lines = 11,        ///< uint32, two by line: vertices of level 0. With level 0.
};

/// Blocks that n numbers take.
[[nodiscard]] inline std::uint64_t n_parts(std::uint64_t n) {
  return (n + terrain_file::kPart - 1) / terrain_file::kPart;
}

[[nodiscard]] inline terrain_file::ColumnKey key_of(Column column, std::size_t level) {
  return {static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(level)};
}

}  // namespace lode::delaunay_pyramid
