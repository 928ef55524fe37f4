#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "grid.h"

namespace lode::raster_import {

/// What GDAL says of a raster beside its samples.
struct GdalFacts {
  std::string format;              ///< GDAL's name of its driver.
  std::string crs;                 ///< As WKT; empty: none.
  bool is_point = false;           ///< Samples are at places, not of cells.
  std::vector<std::string> notes;  ///< What was taken for granted.
};

/// Has GDAL open a file (.gz: what it unpacks to) by whichever of the drivers for rare formats
/// knows it, and copy its band into a GeoTIFF without compression, with its place, scale, offset,
/// unit, nodata value and mask. `path` begins with a slash. Throws std::runtime_error where there
/// is no raster, no such band, where it has files in other directories, or is larger than its files
/// could hold, or than what is free where it is written. `progress`: as copy_grid() has it.
[[nodiscard]] GdalFacts copy_by_gdal(const std::string& path, const Choice& choice,
                                     const std::string& output,
                                     const std::function<void(double, std::uint64_t)>& progress);

}  // namespace lode::raster_import
