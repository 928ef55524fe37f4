#pragma once

#include <string>

#include "terrain_input.h"
#include "text.h"

namespace lode::cli {

/// A .lode file to make of a raster of heights, as typed.
struct TerrainBuildJob {
  std::string input;
  std::string output;
  std::string levels;
  std::string memory_limit;
  TerrainArguments terrain;
  ReadingArguments reading;
};

/// Looks at the arguments alone; `app` knows which options were given.
[[nodiscard]] Result<void> check_terrain_build(const TerrainBuildJob& job, const CLI::App& app);
[[nodiscard]] Result<Outcome> run_terrain_build(const TerrainBuildJob& job, Session& session);

/// The keys and rows of what a built model has, in that CRS.
void add_built_terrain(const BuiltTerrainInfo& info, TerrainModel model, const std::string& crs,
                       Json& json, Table& table);
/// Whether coordinates are longitudes and latitudes; not where PROJ does not know.
[[nodiscard]] bool is_in_angles(const std::string& crs);

}  // namespace lode::cli
