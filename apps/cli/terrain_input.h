#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <string>
#include <vector>

#include "input.h"
#include "text.h"

namespace lode::cli {

/// The options of terrain as typed; --nodata, --max-error and --max-cells are shared with other
/// inputs.
struct TerrainArguments {
  std::string band;  ///< This and the next are of rasters.
  std::string encoding;
  std::string resample;  ///< This and the next are of tiles.
  std::string oversample;
  std::string classes;  ///< This and the next four are of points.
  std::string duplicates;
  std::string max_edge;
  std::string outline;
  std::string crs;
  std::string vertical_crs;  ///< This and the next are of both.
  std::string to_vertical_crs;
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
  [[nodiscard]] bool has_vertical() const {
    return !vertical_crs.empty() || !to_vertical_crs.empty();
  }
  [[nodiscard]] bool has_raster() const {
    return !band.empty() || !encoding.empty() || !resample.empty() || !oversample.empty();
  }
  [[nodiscard]] bool has_points() const {
    return !(classes.empty() && duplicates.empty() && max_edge.empty() && outline.empty() &&
             crs.empty());
  }
  [[nodiscard]] bool is_empty() const {
    return !has_raster() && !has_points() && !has_vertical() && !has_lines() && model.empty() &&
           insertion.empty();
  }
};

/// What is terrain, for messages and help.
inline constexpr const char* kTerrainFiles =
    "a raster of heights (.tif, .asc, .hgt, .png, ...) or scattered points (.las, .xyz, ...)";

enum class TerrainUse : std::uint8_t { rasters, reading, verification, extraction };

/// rasters: --band, --encoding and what heights are above; reading: also the options of points;
/// verification and extraction: also lines, --model and --insertion.
void add_terrain_options(CLI::App& app, TerrainArguments& arguments, TerrainUse use);

/// --resample and --oversample, of what is put in degrees.
void add_resample_option(CLI::App& app, TerrainArguments& arguments);

/// As --insertion names them.
inline constexpr std::array kInsertionOrders{InsertionOrder::levels, InsertionOrder::strict,
                                             InsertionOrder::tiles};
[[nodiscard]] const char* name_of(InsertionOrder order);
[[nodiscard]] Result<InsertionOrder> to_insertion_order(const std::string& insertion);

/// Refuses --insertion tiles with scattered points and with lines.
[[nodiscard]] Result<void> check_insertion(const std::string& path,
                                           const TerrainArguments& arguments);

/// Refuses them for other inputs: they would silently do nothing.
[[nodiscard]] Result<void> check_no_terrain(const TerrainArguments& arguments,
                                            const std::string& path);

/// Refuses options that were given and mean nothing for terrain; `allowed` beside
/// those of every command and of reading.
[[nodiscard]] Result<void> check_only_terrain(const CLI::App& app, const std::string& path,
                                              const std::vector<std::string>& allowed);

[[nodiscard]] Result<HeightReadOptions> to_height_options(const TerrainArguments& arguments,
                                                          const ReadingArguments& reading);

/// Looks at the arguments alone: refuses those of rasters for points, and the other way round.
[[nodiscard]] Result<void> check_terrain_reading(const std::string& path,
                                                 const TerrainArguments& arguments,
                                                 const ReadingArguments& reading);

/// Reads a terrain, or builds what `building` says, and warns of what became of its points and
/// lines. `max_error`: that will be asked for; draped lines keep half of it.
[[nodiscard]] Result<OpenedTerrain> open_terrain(const std::string& path,
                                                 const TerrainArguments& arguments,
                                                 const ReadingArguments& reading,
                                                 const std::optional<TerrainBuildOptions>& building,
                                                 const std::optional<double>& max_error,
                                                 Session& session);

/// Adds what became of lines, where there are some.
void add_lines(const OpenedTerrain& opened, Json& json, Table& table);

/// Refuses --model, --insertion and reading's options with .lode files, which are of a model, and
/// a --model that is built with points.
[[nodiscard]] Result<void> check_terrain_model(const std::string& path,
                                               const TerrainArguments& arguments,
                                               const ReadingArguments& reading);

/// Whether it is a raster of heights or of scattered points by its name.
[[nodiscard]] inline bool is_terrain_path(const std::string& path) {
  return is_height_path(path) || is_point_path(path);
}
/// Of scattered points: that a model can be built of them.
[[nodiscard]] Result<void> check_model_of_points(const std::string& path,
                                                 const TerrainArguments& arguments);
/// Refuses lines with models that cannot keep them.
[[nodiscard]] Result<void> check_lined_model(const std::string& path,
                                             const TerrainArguments& arguments);

/// One of kBuiltTerrainModels by its name.
[[nodiscard]] Result<TerrainModel> to_built_model(const std::string& name);

/// What --model asks to be built, with one level, `finest`, or without it the default ones;
/// nothing where it asks for none. Fails on models that there are not.
[[nodiscard]] Result<std::optional<TerrainBuildOptions>> to_build_options(
    const TerrainArguments& arguments, const std::optional<double>& finest);

/// Of hierarchies, whose meshes come from several levels: `finest`, doubled again and again, or
/// without it the default ones.
void choose_levels(const std::optional<double>& finest, TerrainBuildOptions& building);

/// A number >= 0, or nothing where none was given.
[[nodiscard]] Result<std::optional<double>> to_max_error(const std::string& text);

/// Says where heights were taken otherwise than their file says, and what was done to them.
void warn_of_vertical(const VerticalOutcome& outcome, const std::string& path, Session& session);

/// Refuses depths, where what is above what counts.
[[nodiscard]] Result<void> check_upwards(const HeightFrame& frame, const std::string& path);

/// The keys and rows of a terrain: size, CRS, unit, samples that are missing.
void add_facts(const TerrainFacts& facts, Json& json, Table& table);

}  // namespace lode::cli
