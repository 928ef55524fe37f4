#pragma once

#include <array>
#include <optional>
#include <string>

#include "input.h"
#include "terrain_arguments.h"

namespace lode::cli {

/// Refuses --insertion tiles with scattered points and with lines.
[[nodiscard]] Result<void> check_insertion(const std::string& path,
                                           const TerrainArguments& arguments);

[[nodiscard]] Result<HeightReadOptions> to_height_options(const TerrainArguments& arguments,
                                                          const ReadingArguments& reading);

/// Looks at the arguments alone: refuses those of rasters for points, and the other way round.
[[nodiscard]] Result<void> check_terrain_reading(const std::string& path,
                                                 const TerrainArguments& arguments,
                                                 const ReadingArguments& reading);

/// What a question needs of a raster: see TerrainReadOptions.
struct TerrainQuestion {
  bool keeps_samples = false;
  bool is_closed = false;
  std::optional<std::array<Place, 2>> way{};
  std::string way_crs{};
  bool has_shares = false;  ///< max_error, and levels that are built, are of the range of heights.
};

/// Reads a terrain, or builds what `building` says, and warns of what became of its points and
/// lines. `max_error`: that will be asked for; draped lines keep half of it. Of shares see
/// TerrainQuestion.
[[nodiscard]] Result<OpenedTerrain> open_terrain(
    const std::string& path, const TerrainArguments& arguments, const ReadingArguments& reading,
    const std::optional<TerrainBuildOptions>& building, const std::optional<double>& max_error,
    Session& session, const TerrainQuestion& question = {});

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

/// A number >= 0, or nothing where none was given; with % the share of the range of heights.
[[nodiscard]] Result<std::optional<double>> to_max_error(const std::string& text);
/// Of a tolerance that was typed as a share what it is in a terrain's heights; others stay.
void set_share(const std::string& text, const HeightRange& range, std::optional<double>& tolerance);

/// Says where heights were taken otherwise than their file says, and what was done to them.
void warn_of_vertical(const VerticalOutcome& outcome, const std::string& path, Session& session);

/// Says of a raster that goes round the earth, and was not wrapped, that it can be.
void hint_at_wrap(const OpenedTerrain& opened, const std::string& path, Session& session);

/// Refuses depths, where what is above what counts.
[[nodiscard]] Result<void> check_upwards(const HeightFrame& frame, const std::string& path);

}  // namespace lode::cli
