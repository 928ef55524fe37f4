#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "input.h"
#include "text.h"

namespace lode::cli {

/// The options of a raster that is written, as typed.
struct RasterArguments {
  std::string cell;
  std::string difference;  ///< Another raster to write.
  std::string against;     ///< The raster that a .lode file is of.

  [[nodiscard]] bool is_empty() const {
    return cell.empty() && difference.empty() && against.empty();
  }
};

/// --cell, --difference and --against.
void add_raster_options(CLI::App& app, RasterArguments& arguments);

/// Refuses them for other inputs.
[[nodiscard]] Result<void> check_no_raster(const RasterArguments& arguments,
                                           const std::string& path);
/// Looks at the arguments alone, of a terrain that is made into `output`.
[[nodiscard]] Result<void> check_raster_arguments(const RasterArguments& arguments,
                                                  const std::string& input,
                                                  const std::string& output);
/// As check_surface_extension(), for what is made of terrain.
[[nodiscard]] Result<void> check_terrain_surface(const std::string& path);

[[nodiscard]] Result<TerrainRasterOptions> to_raster_options(const RasterArguments& arguments);

/// Reads the raster of --against, where a model has not all heights itself; warns where it has.
[[nodiscard]] Result<void> read_samples(const RasterArguments& arguments,
                                        const OpenedTerrain& opened, TerrainRasterOptions& wanted,
                                        Session& session);

/// The keys and rows of a raster that was written; `form` is that of the terrain's own.
void add_raster(const TerrainRasterReport& report, const RasterForm& form, Json& json,
                Table& table);

}  // namespace lode::cli
