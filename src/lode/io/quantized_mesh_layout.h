#pragma once

// What encode() and decode_quantized_mesh() agree on.

#include <cstddef>
#include <cstdint>

#include "lode/io/quantized_mesh.h"

namespace lode::io {

/// Vertices that 16 bits can number.
inline constexpr std::size_t kMostSmallVertices = 65536;

/// The sides in the file's order: west, south, east, north.
inline constexpr std::size_t kTileSides = 4;

[[nodiscard]] inline bool is_on_side(LatticePoint node, std::size_t side) {
  const std::int32_t across = side % 2 == 0 ? node.x : node.y;
  return across == (side < 2 ? 0 : QuantizedMesh::kLast);
}

}  // namespace lode::io
