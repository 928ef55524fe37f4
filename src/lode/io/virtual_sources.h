#pragma once

#include <cstdint>
#include <string>

#include "lode/core/result.h"
#include "lode/io/gdal_library.h"

namespace lode::io {

/// Looks at a VRT and at all it is put together from, also through other VRTs, before GDAL reads
/// any sample: files of raster_drivers() that are there and have these bands, none of them the VRT
/// itself. Where samples have no source, or the source says that they are none, the VRT must have a
/// value for that, or a mask: else they would be heights of 0, or of what the source has for
/// missing ones. Returns the bytes of all these files. GDAL's messages are off.
[[nodiscard]] Result<std::uint64_t> check_virtual_sources(const std::string& path,
                                                          const GdalLibrary& gdal);

}  // namespace lode::io
