#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "extraction_options.h"
#include "lode/api/focused_surface.h"
#include "lode/api/mesh_extraction.h"

namespace lode::cli {

/// By which of a mesh's vectors it is deformed, and how much, as typed.
struct WarpArguments {
  std::string field;
  std::string scale;

  [[nodiscard]] bool is_wanted() const { return !field.empty(); }
  [[nodiscard]] bool is_empty() const { return field.empty() && scale.empty(); }
  friend bool operator==(const WarpArguments&, const WarpArguments&) = default;
};

/// The options of foci, meshes and sections as typed.
struct QueryArguments {
  bool is_mesh = false;
  bool is_boundary = false;
  std::vector<std::string> sections;
  std::string threshold;
  std::string opacity;
  WarpArguments warp;
  std::vector<std::string> regions;
  std::vector<std::string> patches;
  std::vector<std::string> field_ranges;
  std::vector<std::string> boxes;
  std::vector<std::string> balls;
  std::vector<std::string> half_spaces;
  std::string max_error_outside;
  std::string max_cells;
  std::string view;
  std::string view_size;  ///< Empty: 1920x1080.
  std::string max_error_px;
  std::string max_space_error;
  std::string deadline_ms;

  friend bool operator==(const QueryArguments&, const QueryArguments&) = default;
  /// Whether the answer is a section. Of a mesh they say where it is to be accurate.
  [[nodiscard]] bool is_section() const { return !is_mesh && !sections.empty(); }
  /// Whether the answer is a mesh, its boundary or a section, and no isosurface.
  [[nodiscard]] bool is_wanted() const { return is_mesh || is_boundary || !sections.empty(); }
  /// Whether it is a surface, but not equally good everywhere.
  [[nodiscard]] bool is_focused() const {
    return !is_wanted() &&
           !(boxes.empty() && balls.empty() && half_spaces.empty() && max_error_outside.empty() &&
             max_cells.empty() && view.empty() && max_error_px.empty() && deadline_ms.empty());
  }
};

/// All of them, as `extract` has them.
void add_query_options(CLI::App& app, QueryArguments& arguments);
/// Those that say where an answer is fine, what is left out, and how large it gets or how long it
/// takes: all that pictures have, too.
void add_focus_options(CLI::App& app, QueryArguments& arguments);

/// Refuses options that the wanted kind of answer does not have. Meshes of cells have views and
/// deadlines of all kinds.
[[nodiscard]] Result<void> check_unused(const QueryArguments& arguments, bool is_of_cells);

/// What --view-size says, without the camera.
[[nodiscard]] Result<View> to_view(const QueryArguments& arguments);
/// With the camera of --view, from its file.
[[nodiscard]] Result<View> read_view(const QueryArguments& arguments);
/// Of --max-error-px, in pixels of the query's view, which there must be, and of --max-space-error.
[[nodiscard]] Result<void> add_space_tolerances(const QueryArguments& arguments, Query& query);
/// Of --deadline-ms, in seconds.
[[nodiscard]] Result<std::optional<double>> to_deadline(const QueryArguments& arguments);

/// But for the view, whose camera is in a file.
[[nodiscard]] Result<FocusedOptions> to_focused_options(const QueryArguments& arguments,
                                                        const ExtractionArguments& extraction);

/// Of those that lie beside all data.
void warn_of_boxes(const std::vector<Box3d>& boxes, const Box3d& bounds, Session& session,
                   const char* when = "");

/// Of boxes and the like, values and budget. `answer`: what asks for it, in messages. The view's
/// camera and the transfer function are in files.
[[nodiscard]] Result<Query> to_query(const QueryArguments& arguments,
                                     const ExtractionArguments& extraction, const char* answer);
/// Refuses --max-error-outside of a query that is as fine everywhere.
[[nodiscard]] Result<void> check_outside(const Query& query);
/// Refuses --view-size of no view.
[[nodiscard]] Result<void> check_view_size(const QueryArguments& arguments);
[[nodiscard]] Result<MeshOptions> to_mesh_options(const QueryArguments& arguments,
                                                  const ExtractionArguments& extraction);
/// Each X0,X1,Y0,Y1,Z0,Z1.
[[nodiscard]] Result<std::vector<Box3d>> parse_boxes(const std::vector<std::string>& texts);
/// Two numbers as A:B, A <= B.
[[nodiscard]] Result<Range> parse_range(const char* option, const std::string& text);
/// With a plane at least; the first one is the options'.
[[nodiscard]] Result<SectionOptions> to_section_options(const QueryArguments& arguments,
                                                        const ExtractionArguments& extraction);
[[nodiscard]] Result<std::vector<SectionPlane>> to_planes(const QueryArguments& arguments);
/// Of a mesh: accurate along --section's planes.
[[nodiscard]] Result<void> add_section_foci(const QueryArguments& arguments, Query& query);
/// None where none is asked for.
[[nodiscard]] Result<std::optional<Range>> to_threshold(const QueryArguments& arguments);

}  // namespace lode::cli
