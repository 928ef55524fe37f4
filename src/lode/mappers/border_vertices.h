#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/surface.h"

namespace lode {

/// By vertex of an oriented surface of triangles: whether an edge of its triangles has a triangle
/// on one side only.
[[nodiscard]] std::vector<std::uint8_t> find_border_vertices(const Surface& surface);

}  // namespace lode
