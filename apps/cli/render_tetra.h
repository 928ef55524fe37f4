#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "extraction_options.h"
#include "input.h"
#include "lode/api/mesh_picture.h"
#include "query_options.h"
#include "warp_options.h"

namespace lode::cli {

/// The options of `lode render` that only meshes of cells have, as typed.
struct TetraPictureArguments {
  QueryArguments query;  ///< With sections, opacity and warp; neither --mesh nor --boundary.
  bool has_boundary = false;
  bool has_wireframe = false;
  bool has_points = false;

  /// Whether all of the mesh is shown, and not isosurfaces alone.
  [[nodiscard]] bool is_of_mesh() const {
    return !query.opacity.empty() || !query.sections.empty() || has_boundary || has_wireframe ||
           has_points;
  }
  [[nodiscard]] bool is_empty() const { return !is_of_mesh() && query == QueryArguments(); }
};

void add_tetra_picture_options(CLI::App& app, TetraPictureArguments& arguments);

/// The arguments of `lode render` for a mesh of cells.
struct TetraPictureJob {
  const std::string& input;
  const std::string& output;
  const std::string& camera;       ///< A file, or empty.
  const std::string& save_camera;  ///< The same.
  const ExtractionArguments& extraction;
  const ReadingArguments& reading;
  const TetraPictureArguments& picture;
  const std::string& max_error_px;  ///< Of the view, or of the picture; as given.
  RenderOptions options;            ///< All but the camera.
  bool is_default_samples = true;
};

/// Looks at the arguments alone.
[[nodiscard]] Result<void> check_tetra_picture(const TetraPictureJob& job);
/// Builds the hierarchy of a mesh of cells in memory, and draws the mesh of a query: its volume,
/// isosurfaces and sections.
[[nodiscard]] Result<Outcome> run_tetra_picture(const TetraPictureJob& job, Session& session);

[[nodiscard]] Json camera_json(const Camera& camera);

}  // namespace lode::cli
