#pragma once

#include <string>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/sample_storage.h"

namespace lode::io {

/// Legacy VTK (.vtk), ASCII or BINARY: STRUCTURED_POINTS, and RECTILINEAR_GRID with evenly spaced
/// axes; point data only.
[[nodiscard]] Result<Image> read_vtk_legacy(const std::string& path, const SampleStorage& storage);

}  // namespace lode::io
