#pragma once

#include <string>

#include "lode/io/point_file.h"

namespace lode::io {

/// Reads text, perhaps compressed (.gz): x, y and height a line, with commas, semicolons, tabs or
/// blanks between them, and any columns after. A first line that begins with a word is a heading:
/// where it names x, y and height (x, lon, longitude, easting; y, lat, latitude, northing; z,
/// height, elevation, altitude, depth; any case) those columns are taken, else the first three.
/// Blank lines and those that begin with # are left out. Where x and y are decimals they are on a
/// lattice whose step is that of the most decimals. Heights that are no finite number are missing.
/// Fails, naming file and line, on anything else.
[[nodiscard]] Result<PointFile> read_point_text(const std::string& path,
                                                const PointReadOptions& options,
                                                Progress& progress);

}  // namespace lode::io
