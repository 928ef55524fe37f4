#pragma once

#include <string>

#include "lode/core/placed_surface.h"
#include "lode/core/result.h"

namespace lode::io {

/// Reads VTK XML PolyData of one piece: Points, point data isovalue and normals, Polys (as
/// triangle fans) and Lines (as segments). Strips are refused, vertices (cells) skipped.
[[nodiscard]] Result<PlacedSurface> read_vtp(const std::string& path);

}  // namespace lode::io
