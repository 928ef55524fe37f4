#pragma once

#include <optional>
#include <string>
#include <vector>

#include "extraction_options.h"
#include "input.h"
#include "lode/api/mesh_picture.h"
#include "lode/api/tetra_session.h"
#include "query_options.h"
#include "render_path.h"
#include "tetra_input.h"
#include "warp_options.h"

namespace lode::cli {

// How a picture of a mesh of cells is made, for one and for those of a moving camera alike.

/// The options of `lode render` that only meshes of cells have, as typed.
struct TetraPictureArguments {
  QueryArguments query;  ///< With sections, opacity and warp; neither --mesh nor --boundary.
  std::string boundary;  ///< "film", "field" or empty.
  std::string legend;    ///< "on", "off" or empty.
  std::string color_by;  ///< A further field, or empty.
  std::string color_range;
  bool has_wireframe = false;
  bool has_points = false;

  /// Whether all of the mesh is shown, and not isosurfaces alone.
  [[nodiscard]] bool is_of_mesh() const {
    return !query.opacity.empty() || !query.sections.empty() || !boundary.empty() ||
           has_wireframe || has_points;
  }
  [[nodiscard]] bool is_empty() const {
    return !is_of_mesh() && query == QueryArguments() && color_by.empty() && color_range.empty();
  }
};

/// The arguments of `lode render` for a mesh of cells.
struct TetraPictureJob {
  const std::string& input;
  const std::string& output;
  const std::string& camera;       ///< A file, or empty.
  const std::string& save_camera;  ///< The same.
  const ExtractionArguments& extraction;
  const ReadingArguments& reading;
  const TetraPictureArguments& picture;
  const PathArguments& path;  ///< Its pixels are those of single pictures, too.
  RenderOptions options;      ///< All but the camera.
  bool is_default_samples = true;

  /// The boundary, coloured, if nothing else is asked for.
  [[nodiscard]] bool is_default() const {
    return extraction.isovalues.empty() && !picture.is_of_mesh();
  }
  /// With the field of colours before others.
  [[nodiscard]] ReadingArguments reading_with_colors() const {
    ReadingArguments arguments = reading;
    if (!picture.color_by.empty()) arguments.with.insert(arguments.with.begin(), picture.color_by);
    return arguments;
  }
  /// What is asked of the mesh, as typed.
  [[nodiscard]] QueryArguments query() const {
    QueryArguments arguments = picture.query;
    arguments.max_error_px = path.max_error_px;
    return arguments;
  }
  /// Whether the view is that of the picture's camera: what it does not show may be coarse. Not
  /// where there is another, and not of a deformed mesh, whose cells are where the hierarchy does
  /// not know.
  [[nodiscard]] bool has_own_view() const {
    return picture.query.view.empty() && !picture.query.warp.is_wanted();
  }
};

/// What is asked of the mesh, and what is shown, but for the camera and a view of its own.
struct TetraPicturePlan {
  MeshPictureOptions shown;
  TetraMeshOptions wanted;
};

/// Looks at the arguments alone, and at the files of cameras. `camera`: of the picture; one of
/// those that it has.
[[nodiscard]] Result<TetraPicturePlan> check_picture_plan(const TetraPictureJob& job,
                                                          const std::optional<Camera>& camera);
/// The same, with what depends on the mesh.
[[nodiscard]] Result<TetraPicturePlan> plan_picture(const TetraPictureJob& job,
                                                    const TetraInput& input,
                                                    const std::optional<Camera>& camera,
                                                    Session& session);

/// How a picture came to be.
struct TetraPicture {
  Image image{};
  MeshReport mesh{};
  MeshPictureReport picture{};
  std::vector<std::string> warnings{};
  std::optional<Warped> warped{};
};

/// Asks for the mesh and draws it. `camera`: unset, all of the mesh is shown.
[[nodiscard]] Result<TetraPicture> draw_picture(const TetraPictureJob& job, const TetraInput& input,
                                                const TetraPicturePlan& plan,
                                                const std::optional<Camera>& camera,
                                                TetraSession& questions, Session& session);

}  // namespace lode::cli
