#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "input.h"
#include "lode/api/terrain_picture.h"
#include "terrain_input.h"

namespace lode::cli {

/// The options of `lode render` that only rasters of heights have, as typed.
struct TerrainPictureArguments {
  TerrainArguments terrain;
  std::string exaggeration;
  std::string contours;
  bool is_from_above = false;

  [[nodiscard]] bool is_empty() const {
    return exaggeration.empty() && contours.empty() && !is_from_above;
  }
};

void add_terrain_picture_options(CLI::App& app, TerrainPictureArguments& arguments);

/// Refuses them for other inputs: they would silently do nothing.
[[nodiscard]] Result<void> check_no_terrain_picture(const TerrainPictureArguments& arguments,
                                                    const std::string& path);

/// The arguments of `lode render` for a raster of heights.
struct TerrainPictureJob {
  const std::string& input;
  const std::string& output;
  const std::string& camera;       ///< A file, or empty.
  const std::string& save_camera;  ///< The same.
  const std::string& max_error;
  const std::string& max_cells;
  const std::string& max_error_px;
  const ReadingArguments& reading;
  const TerrainPictureArguments& picture;
  RenderOptions options;  ///< All but the camera.
};

/// Looks at the arguments alone. `app`: to find options that mean nothing here.
[[nodiscard]] Result<void> check_terrain_picture(const TerrainPictureJob& job, const CLI::App& app);
[[nodiscard]] Result<Outcome> run_terrain_picture(const TerrainPictureJob& job, Session& session);

}  // namespace lode::cli
