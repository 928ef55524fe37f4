#pragma once

#include <string>

#include "lode/io/point_file.h"

namespace lode::io {

/// Reads LAS 1.0 to 1.4, point formats 0 to 10, not compressed (ASPRS, "LAS specification 1.4 -
/// R15", 2019). Coordinates are whole numbers times a scale: where x and y have the same one their
/// lattice is known. Withheld points are left out, as the specification wants it. The CRS is that
/// of the WKT record, or of an EPSG code among the GeoTIFF keys; the vertical unit that of either.
/// Fails, naming file and offset, on compressed points (LAZ), on sizes that the file does not have,
/// and on scales that are none.
[[nodiscard]] Result<PointFile> read_las(const std::string& path, const PointReadOptions& options,
                                         Progress& progress);

}  // namespace lode::io
