#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "input.h"
#include "lode/api/terrain.h"
#include "query_options.h"
#include "text.h"

namespace lode::cli {

/// The options of foci that only terrain has, as typed; the others are QueryArguments'.
struct TerrainFocusArguments {
  std::string point;
  std::string growth;
  std::string exaggeration;  ///< Of the view's picture.

  [[nodiscard]] bool is_empty() const {
    return point.empty() && growth.empty() && exaggeration.empty();
  }
};

/// X0,X1,Y0,Y1 of an option.
[[nodiscard]] Result<PlaceBox> parse_place_box(const char* option, const std::string& text);

void add_terrain_focus_options(CLI::App& app, TerrainFocusArguments& arguments);

/// Where the tolerance holds; nothing where it does everywhere. The metric and the view's camera,
/// which is in a file, are left to the caller. `max_error`: as typed; empty: not given.
[[nodiscard]] Result<std::optional<TerrainFocus>> to_terrain_focus(
    const QueryArguments& query, const TerrainFocusArguments& arguments,
    const std::string& max_error);

/// Warns of boxes that lie in part outside of the raster, where nothing comes of them.
void warn_of_boxes(const TerrainFocus& focus, const HeightFrame& frame, Session& session);

/// Null without one. `report`: of a focus with a view.
[[nodiscard]] Json focus_json(const std::optional<TerrainFocus>& focus,
                              const std::optional<TerrainViewReport>& report);

/// TerrainViewReport::achieved_px.
[[nodiscard]] std::string describe_achieved(double pixels);

/// What a point's --growth is for.
void add_focus_rows(const TerrainFocus& focus, Table& table);

/// Rows of what is seen.
void add_view_rows(const TerrainFocus& focus, const TerrainViewReport& report, Table& table);

/// Says where the view shows nothing, or the model is not as fine as it would take.
void warn_of_view(const TerrainViewReport& report, TerrainModel model, double finest_error,
                  Session& session);

}  // namespace lode::cli
