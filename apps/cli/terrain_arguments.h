#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "input.h"

namespace lode::cli {

/// The options of terrain as typed; --nodata, --max-error and --max-cells are shared with other
/// inputs.
struct TerrainArguments {
  std::string band;  ///< This and the next two are of rasters.
  std::string variable;
  std::string encoding;
  bool wrap = false;
  std::string resample;  ///< This and the next are of tiles.
  std::string oversample;
  std::string classes;  ///< This and the next three are of points.
  std::string duplicates;
  std::string max_edge;
  std::string outline;
  std::string crs;  ///< This and the next two are of both.
  std::string vertical_crs;
  std::string to_vertical_crs;
  std::string to_crs;  ///< Of what comes out, of files too; not among those that is_empty() means.
  std::string model;
  std::string insertion;
  bool keep_features = false;  ///< This and the next four make lines edges.
  std::string feature_relief;
  std::string breaklines;
  bool drape = false;
  std::string drape_error;

  [[nodiscard]] bool has_lines() const {
    return keep_features || drape || !drape_error.empty() || !feature_relief.empty() ||
           !breaklines.empty();
  }
  [[nodiscard]] TerrainArguments without_lines() const {
    TerrainArguments plain = *this;
    plain.keep_features = plain.drape = false;
    for (std::string* text : {&plain.feature_relief, &plain.breaklines, &plain.drape_error})
      text->clear();
    return plain;
  }
  [[nodiscard]] bool has_vertical() const {
    return !vertical_crs.empty() || !to_vertical_crs.empty();
  }
  [[nodiscard]] bool has_raster() const {
    return wrap || !band.empty() || !variable.empty() || !encoding.empty() || !resample.empty() ||
           !oversample.empty();
  }
  [[nodiscard]] bool has_points() const {
    return !(classes.empty() && duplicates.empty() && max_edge.empty() && outline.empty());
  }
  [[nodiscard]] bool is_empty() const {
    return !has_raster() && !has_points() && !has_vertical() && !has_lines() && crs.empty() &&
           model.empty() && insertion.empty();
  }
};

/// What is terrain, for messages and help.
inline constexpr const char* kTerrainFiles =
    "a raster of heights (.tif, .asc, .hgt, .nc, .png, ...) or scattered points (.las, .xyz, ...)";

enum class TerrainUse : std::uint8_t { rasters, reading, verification, extraction };

/// rasters: --band, --encoding, --crs and what heights are above; reading: also the options of
/// points; verification and extraction: also lines, --model and --insertion.
void add_terrain_options(CLI::App& app, TerrainArguments& arguments, TerrainUse use);

/// --resample and --oversample, of what is put in degrees.
void add_resample_option(CLI::App& app, TerrainArguments& arguments);

/// As --insertion has it.
[[nodiscard]] Result<InsertionOrder> to_insertion_order(const std::string& insertion);

/// Refuses them for other inputs: they would silently do nothing.
[[nodiscard]] Result<void> check_no_terrain(const TerrainArguments& arguments,
                                            const std::string& path);

/// Refuses options that were given and mean nothing for terrain; `allowed` beside
/// those of every command and of reading.
[[nodiscard]] Result<void> check_only_terrain(const CLI::App& app, const std::string& path,
                                              const std::vector<std::string>& allowed);

}  // namespace lode::cli
