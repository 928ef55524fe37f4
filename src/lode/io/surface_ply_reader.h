#pragma once

#include <string>

#include "lode/core/placed_surface.h"
#include "lode/core/result.h"

namespace lode::io {

/// Reads ASCII and binary PLY of either byte order: x y z, nx ny nz and isovalue of the vertices,
/// faces (as triangle fans) and edges; other elements and properties are skipped.
[[nodiscard]] Result<PlacedSurface> read_ply(const std::string& path);

}  // namespace lode::io
