#pragma once

// What save() and open() agree on; docs/format.md, section 7.

#include <array>
#include <cstdint>
#include <string_view>

#include "lode/models/terrain/terrain_file/columns.h"

namespace lode::hierarchy_file {

/// As the enumerators of Kind.
inline constexpr std::array<std::string_view, 2> kModelNames{"adaptive_triangulation",
                                                             "hierarchical_delaunay"};

inline constexpr std::uint32_t kLayout = 4;

enum class Column : std::uint32_t {
  x = 1,            ///< int32 by vertex, in nodes of the fine lattice.
  y = 2,            ///< The same.
  height = 3,       ///< float64 by vertex.
  corner = 4,       ///< uint32, three by triangle: vertices.
  error = 5,        ///< float32 by triangle.
  refined = 6,      ///< uint32 by refinement: the triangle that it replaces.
  n_triangles = 7,  ///< uint32 by refinement: how many replace it.
  line = 8,         ///< uint32, two by line: vertices of level 0.
  crowded = 9       ///< uint32 by crowded triangle: which.
};

[[nodiscard]] inline terrain_file::ColumnKey key_of(Column column) {
  return {static_cast<std::uint32_t>(column), 0};
}

}  // namespace lode::hierarchy_file
