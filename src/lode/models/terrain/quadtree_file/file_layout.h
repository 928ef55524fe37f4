#pragma once

// What save() and open() agree on; docs/format.md, section 8.

#include <array>
#include <cstdint>
#include <string_view>

#include "lode/models/terrain/terrain_file/columns.h"

namespace lode::quadtree_file {

/// As the alternatives of QuadtreeModel::tree.
inline constexpr std::array<std::string_view, 3> kModelNames{
    "surface_quadtree", "quaternary_triangulation", "restricted_quadtree"};

inline constexpr std::uint32_t kLayout = 2;

/// Beside those of terrain_file::RasterColumn.
enum class Column : std::uint32_t {
  error = 3,  ///< float32 by square, or two by square, of the level.
};

[[nodiscard]] inline terrain_file::ColumnKey key_of(Column column, std::int32_t level = 0) {
  return {static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(level)};
}

}  // namespace lode::quadtree_file
