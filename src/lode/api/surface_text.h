#pragma once

#include <cstdint>
#include <string>

#include "lode/core/surface.h"

namespace lode {

/// "(x, y, z)".
[[nodiscard]] std::string describe_place(const Vec3d& world);

/// "vertex 5 at (x, y, z)".
[[nodiscard]] std::string describe_vertex(const Surface& surface, std::uint32_t vertex);

/// "the edge from vertex 5 at (x, y, z) to vertex 6 at (x, y, z)"; of contour lines, whose ends
/// come as two equal vertices, "the end at vertex 5 ...".
[[nodiscard]] std::string describe_edge(const Surface& surface, std::uint32_t from,
                                        std::uint32_t to);

/// "triangle 7 at (x, y, z)", which is its first corner; or "line 7 at ...".
[[nodiscard]] std::string describe_cell(const Surface& surface, std::uint32_t cell);

}  // namespace lode
