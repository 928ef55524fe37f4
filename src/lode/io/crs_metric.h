#pragma once

#include <string>

#include "lode/core/horizontal_metric.h"
#include "lode/core/result.h"

namespace lode::io {

/// What a CRS in WKT says of distances. Empty: no CRS. Fails on text that GDAL does not take, and
/// where GDAL is not installed.
[[nodiscard]] Result<HorizontalMetric> read_metric(const std::string& crs);

}  // namespace lode::io
