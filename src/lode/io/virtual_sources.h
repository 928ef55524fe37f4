#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/gdal_library.h"

namespace lode::io {

/// A VRT as GDAL is to read it: written anew of what is understood here, with whole paths, so that
/// nothing is read that was not looked at.
struct CheckedVirtualRaster {
  std::string text;  ///< XML, which GDAL opens in place of a file.
  /// By band: why its samples are no heights, unless it has a mask; empty: they are.
  std::vector<std::string> faults{};
  std::uint64_t n_bytes = 0;      ///< Of all files.
  std::int32_t n_block_rows = 1;  ///< Of the tallest block of a file.
};

/// Reads a VRT and looks at all files it is put together from: they are there, one of
/// raster_drivers() is what GDAL takes them for, and they have these bands; none is a VRT. Where
/// samples have no source, or a file says that they are none, the VRT must have a value for that:
/// else they would be heights of 0, or of what the file has for missing ones. Files that agree on a
/// unit, of which the VRT says nothing, tell it. GDAL's messages are off.
[[nodiscard]] Result<CheckedVirtualRaster> check_virtual_raster(const std::string& path,
                                                                const GdalLibrary& gdal);

}  // namespace lode::io
