#pragma once

#include <string>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/io/surface_file.h"

namespace lode::io {

/// Binary glTF 2.0: one node with the origin as its translation, one mesh of one primitive with
/// POSITION, NORMAL and _ISOVALUE. Axes are written as they are, whatever glTF calls up. Fails
/// past 4 GiB, which is the format's limit.
[[nodiscard]] Result<void> write_glb(const std::string& path, const Surface& surface,
                                     const SurfaceWriteOptions& options, Progress& progress);

/// Reads what write_glb() writes: at most one mesh of one primitive, no buffers outside the file,
/// no transformation but a translation.
[[nodiscard]] Result<Surface> read_glb(const std::string& path);

}  // namespace lode::io
