#pragma once

#include <string>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/io/surface_file.h"

namespace lode::io {

/// Binary little-endian PLY: float coordinates, or double ones when the surface has an origin
/// (noted in a comment, so that reading restores it) or options have places; nx ny nz, isovalue and
/// origin_x .. origin_z where the surface has them; faces as uchar counts and int (uint past 2^31
/// vertices) indices; contour lines as edges.
[[nodiscard]] Result<void> write_ply(const std::string& path, const Surface& surface,
                                     const SurfaceWriteOptions& options, Progress& progress);

}  // namespace lode::io
