#pragma once

#include <string>

#include "terrain_input.h"

namespace lode::cli {

/// A TIN of a raster of heights, as asked for.
struct TerrainJob {
  std::string input;
  std::string output;
  std::string max_error;
  std::string max_cells;
  TerrainArguments terrain;
  ReadingArguments reading;
};

/// Looks at the arguments alone; `app` knows which options were given.
[[nodiscard]] Result<void> check_terrain_job(const TerrainJob& job, const CLI::App& app);
[[nodiscard]] Result<Outcome> run_terrain_job(const TerrainJob& job, Session& session);

/// What `lode info` says of a raster of heights.
[[nodiscard]] Result<Outcome> run_terrain_info(const std::string& path,
                                               const TerrainArguments& terrain,
                                               const ReadingArguments& reading, Session& session);

}  // namespace lode::cli
