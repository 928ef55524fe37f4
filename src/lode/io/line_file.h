#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/place_line.h"
#include "lode/core/result.h"

namespace lode::io {

/// The lines of a file of features.
struct LineFile {
  std::vector<PlaceLine> lines;
  std::uint64_t n_points = 0;  ///< Features, or parts of them, that are points: left out.
};

/// Reads lines from GeoJSON, a GeoPackage or a shapefile through GDAL, of all layers, with heights
/// where they have some, and rings of polygons as lines; arcs become chords. x and y come in the
/// coordinates of a CRS, as WKT, as polygons_in() has them; heights as they are. Fails, naming the
/// file and the feature, on anything else, on points without a line, on coordinates that are not
/// finite, and on lines of one point.
[[nodiscard]] Result<LineFile> read_lines(const std::string& path, const std::string& crs);

}  // namespace lode::io
