#pragma once

#include <string>

#include "terrain_arguments.h"
#include "terrain_input.h"

namespace lode::cli {

/// What `lode info` says of a raster of heights, or of a .lode file made of one.
[[nodiscard]] Result<Outcome> run_terrain_info(const std::string& path,
                                               const TerrainArguments& terrain,
                                               const ReadingArguments& reading, Session& session);

}  // namespace lode::cli
