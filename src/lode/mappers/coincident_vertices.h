#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/vec.h"

namespace lode {

/// For each position, the lowest index with the same coordinates (-0 equals 0).
/// Positions must be finite. O(n log n), 8 bytes a vertex.
[[nodiscard]] std::vector<std::uint32_t> find_coincident_vertices(std::span<const Vec3f> positions);

}  // namespace lode
