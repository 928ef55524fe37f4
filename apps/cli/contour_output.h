#pragma once

#include <string>

#include "terrain_query.h"

namespace lode::cli {

/// To .gpkg, .geojson or .vtp, whole or not at all.
[[nodiscard]] Result<void> write_contours(const std::string& path, const TerrainAnswerer& answerer,
                                          const TerrainContours& contours, Progress& progress);
/// To .gpkg or .geojson.
[[nodiscard]] Result<void> write_bands(const std::string& path, const TerrainAnswerer& answerer,
                                       const TerrainBands& bands, Progress& progress);

}  // namespace lode::cli
