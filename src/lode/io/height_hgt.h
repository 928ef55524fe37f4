#pragma once

#include <string>

#include "lode/io/height_reader.h"

namespace lode::io {

/// Whether the name is that of an SRTM tile, perhaps compressed.
[[nodiscard]] bool is_hgt_path(const std::string& path);

/// Reads an SRTM tile: int16, big endian, n by n samples from north to south, a degree wide. Its
/// name starts with its south-western corner, such as N46W123.
[[nodiscard]] Result<HeightRaster> read_hgt(const std::string& path,
                                            const HeightReadOptions& options);

}  // namespace lode::io
