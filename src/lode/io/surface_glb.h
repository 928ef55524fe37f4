#pragma once

#include <string>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/io/surface_file.h"

namespace lode::io {

/// Binary glTF 2.0: a node with the origin as its translation, one mesh of one primitive with
/// POSITION, NORMAL and _ISOVALUE, in one that turns z up and y, and makes metres of the units of
/// x, y and z. Fails past 4 GiB, which is the format's limit.
[[nodiscard]] Result<void> write_glb(const std::string& path, const Surface& surface,
                                     const SurfaceWriteOptions& options, Progress& progress);

/// Reads what write_glb() writes: at most one mesh of one primitive, no buffers outside the file,
/// no transformation but these two, of which the outer one is not applied.
[[nodiscard]] Result<Surface> read_glb(const std::string& path);

}  // namespace lode::io
