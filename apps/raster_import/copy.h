#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "grid.h"

namespace lode::raster_import {

/// Writes a grid as a GeoTIFF without compression and without a CRS: samples as they are stored, of
/// their own type, from north to south and west to east, with scale, offset, unit and one nodata
/// value. `progress(fraction, bytes of all samples)` is called now and then. Throws
/// std::runtime_error where the grid is larger than a file of n_input bytes could hold, or than
/// what is free where it is written; memory: up to 1.5 GiB, mostly far less.
void copy_grid(const Grid& grid, const Choice& choice, std::uint64_t n_input,
               const std::string& output,
               const std::function<void(double, std::uint64_t)>& progress);

}  // namespace lode::raster_import
