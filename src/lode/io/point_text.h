#pragma once

#include <string>

#include "lode/io/point_file.h"

namespace lode::io {

/// Reads text, perhaps compressed (.gz): x, y and height a line, and any columns after. Between
/// columns are commas or semicolons, whichever comes first in a line, with blanks beside them or
/// not, else blanks and tabs; all lines with the same separator have as many columns. A first line
/// that begins with a word is a heading, which names x, y and height, in any case: x or point_x
/// with y or point_y; lon, long, lng or longitude with lat or latitude (has_degrees); e, east or
/// easting with n, north or northing; z, point_z, h, height, ele, elev, elevation, alt, altitude,
/// depth or grid_code. Where it is three other names, or there is none, the first three columns are
/// taken. Blank lines and those that begin with # are left out. Where x and y are decimals they are
/// on a lattice whose step is that of the most decimals. Heights that are no finite number are
/// missing. Fails, naming file and line, on anything else.
[[nodiscard]] Result<PointFile> read_point_text(const std::string& path,
                                                const PointReadOptions& options,
                                                Progress& progress);

}  // namespace lode::io
