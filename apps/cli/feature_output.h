#pragma once

#include <string>

#include "lode/api/terrain_features.h"
#include "terrain_query.h"

namespace lode::cli {

/// To .gpkg (layers critical_points, ridges, channels), .geojson or .vtp, whole or not at all.
[[nodiscard]] Result<void> write_features(const std::string& path, const TerrainInput& input,
                                          const TerrainFeatures& features, Progress& progress);

}  // namespace lode::cli
