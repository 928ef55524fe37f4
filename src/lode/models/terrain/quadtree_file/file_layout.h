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

enum class Column : std::uint32_t {
  height = 1,    ///< By sample, row by row, in the type that HeightType says; 0 where none is.
  is_valid = 2,  ///< uint8 by sample; only where heights are missing.
  error = 3,     ///< float32 by square, or two by square, of the level.
  kept = 4,      ///< uint32 twice by kept sample: column and row.
};

/// As the alternatives of HeightGrid::heights.
enum class HeightType : std::uint8_t { int16 = 0, uint16 = 1, float32 = 2, float64 = 3 };

[[nodiscard]] inline terrain_file::ColumnKey key_of(Column column, std::int32_t level = 0) {
  return {static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(level)};
}

}  // namespace lode::quadtree_file
