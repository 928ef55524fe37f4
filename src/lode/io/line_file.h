#pragma once

#include <string>
#include <vector>

#include "lode/core/place_line.h"
#include "lode/core/result.h"

namespace lode::io {

/// Reads lines from GeoJSON, a GeoPackage or a shapefile through GDAL, one layer of them, with
/// heights where they have some, and rings of polygons as lines; arcs become chords. x and y come
/// in the coordinates of a CRS, as WKT, as polygons_in() has them; heights as they are. Fails,
/// naming the file and the feature, on anything else, on coordinates that are not finite, and on
/// lines of one point.
[[nodiscard]] Result<std::vector<PlaceLine>> read_lines(const std::string& path,
                                                        const std::string& crs);

}  // namespace lode::io
