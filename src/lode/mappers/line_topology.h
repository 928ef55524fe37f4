#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/surface.h"
#include "lode/mappers/surface_topology.h"
#include "lode/mappers/vertex_corners.h"

namespace lode {

/// The part of check_topology that looks at each vertex of a set of contour lines. Fills the
/// report's counts but for degenerate lines, duplicates and components; `is_boundary` gets 1 for
/// each end point.
void check_line_vertices(const Surface& surface, const VertexCorners& corners,
                         TopologyReport& report, std::vector<std::uint8_t>& is_boundary);

}  // namespace lode
