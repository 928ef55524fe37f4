#pragma once

#include <string>

#include "lode/core/horizontal_metric.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode::io {

/// What a CRS in WKT says of distances. Empty: no CRS. Fails on text that GDAL does not take, and
/// where GDAL is not installed.
[[nodiscard]] Result<HorizontalMetric> read_metric(const std::string& crs);

/// Degrees of WGS 84 of a place x, y of a CRS in WKT, as PROJ transforms it. Fails where it cannot.
[[nodiscard]] Result<Vec<double, 2>> to_wgs84(const std::string& crs, Vec<double, 2> place);

}  // namespace lode::io
