#pragma once

#include <string>

namespace lode::raster_import {

/// Of an HDF5 file: refuses links to other files, samples that are stored in others or put together
/// from them, and links of kinds that are not HDF5's own. Throws std::runtime_error, also where the
/// file cannot be gone through.
void check_outside_files(const std::string& path);

}  // namespace lode::raster_import
