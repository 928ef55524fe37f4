#pragma once

#include <string>

#include "lode/core/placed_surface.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/io/surface_file.h"

namespace lode::io {

/// Wavefront OBJ: v and vn lines and f (or l) lines, with as many digits as reading back exactly
/// needs. An origin is added to the coordinates and noted in a comment; with places coordinates are
/// theirs.
[[nodiscard]] Result<void> write_obj(const std::string& path, const Surface& surface,
                                     const SurfaceWriteOptions& options, Progress& progress);

/// Reads v, vn, f and l lines (other lines are skipped). Normals are kept when each vertex has
/// one. Coordinates are read as float32, or as doubles relative to an origin when they are far
/// from zero compared to their extent, or our writer noted an origin, or places: these come, too.
[[nodiscard]] Result<PlacedSurface> read_obj(const std::string& path);

}  // namespace lode::io
