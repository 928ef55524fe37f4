#pragma once

#include <string>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/io/surface_file.h"

namespace lode::io {

/// VTK XML PolyData with raw appended arrays: Points as Float32, or Float64 when the surface has
/// an origin (noted as field data), point data Normals, isovalue and origin, Polys or Lines.
[[nodiscard]] Result<void> write_vtp(const std::string& path, const Surface& surface,
                                     const SurfaceWriteOptions& options, Progress& progress);

}  // namespace lode::io
