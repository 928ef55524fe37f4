#pragma once

#include <string>
#include <vector>

#include "lode/api/terrain_tin.h"

namespace lode::cli {

/// Places of a text file: numbers with commas, semicolons, tabs or blanks between them, x and y a
/// line. A first line that begins with a word is a heading: where it names x and y (or lon and lat,
/// longitude and latitude, easting and northing; any case) these columns are taken, else the first
/// two, and others may follow. Blank lines and those that begin with # are left out. Fails, naming
/// file and line, on anything else, and where there is no place.
[[nodiscard]] Result<std::vector<Place>> read_places(const std::string& path);

}  // namespace lode::cli
