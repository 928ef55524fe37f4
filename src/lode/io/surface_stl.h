#pragma once

#include <string>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/io/surface_file.h"

namespace lode::io {

/// Binary STL, with facet normals. Fails for lines and for a surface with an origin,
/// unless it is empty.
[[nodiscard]] Result<void> write_stl(const std::string& path, const Surface& surface,
                                     const SurfaceWriteOptions& options, Progress& progress);

/// Reads binary and ASCII STL. Corners with equal coordinates become one vertex, in the order of
/// first appearance; facet normals are dropped.
[[nodiscard]] Result<Surface> read_stl(const std::string& path);

}  // namespace lode::io
