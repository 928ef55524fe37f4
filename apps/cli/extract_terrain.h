#pragma once

#include <string>

#include "terrain_focus_options.h"
#include "terrain_input.h"
#include "terrain_raster_options.h"

namespace lode::cli {

/// A TIN of a terrain, as asked for.
struct TerrainJob {
  std::string input;
  std::string output;
  std::string max_error;
  std::string clip;
  QueryArguments query;  ///< --max-cells and foci.
  TerrainFocusArguments focus;
  RasterArguments raster;
  TerrainArguments terrain;
  ReadingArguments reading;
};

/// --max-error, --max-cells and --insertion; empty: not given.
[[nodiscard]] Result<TerrainOptions> to_terrain_options(const std::string& max_error,
                                                        const std::string& max_cells,
                                                        const TerrainArguments& terrain);

/// Looks at the arguments alone; `app` knows which options were given.
[[nodiscard]] Result<void> check_terrain_job(const TerrainJob& job, const CLI::App& app);
[[nodiscard]] Result<Outcome> run_terrain_job(const TerrainJob& job, Session& session);

}  // namespace lode::cli
