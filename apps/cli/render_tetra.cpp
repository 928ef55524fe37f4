#include "render_tetra.h"

#include <optional>
#include <string>
#include <vector>

#include "output_folder.h"
#include "outputs.h"
#include "render_path.h"
#include "render_tetra_path.h"
#include "tetra_input.h"
#include "tetra_query_options.h"
#include "text.h"

namespace lode::cli {
namespace {

std::vector<std::string> outputs_of(const TetraPictureJob& job) {
  return job.save_camera.empty() ? std::vector{job.output}
                                 : std::vector{job.output, job.save_camera};
}

/// The cameras of --camera-path; none without it. `bounds`: of the mesh.
Result<std::vector<Camera>> path_cameras(const TetraPictureJob& job, const Box3d& bounds) {
  if (!job.path.is_wanted()) return std::vector<Camera>{};
  return camera_path(job.path.path, bounds,
                     static_cast<double>(job.options.width) / job.options.height);
}

/// The picture's: that of --camera, or the first of a path. None: all of the mesh is shown.
Result<std::optional<Camera>> picture_camera(const TetraPictureJob& job,
                                             const std::vector<Camera>& path) {
  if (!job.camera.empty()) {
    LODE_TRY(const Camera camera, read_camera(job.camera));
    return std::optional(camera);
  }
  return path.empty() ? std::nullopt : std::optional(path.front());
}

/// All that there is to tell.
struct TetraPictures {
  const TetraPicturePlan& plan;
  const TetraPicture& picture;
  const Json& path;  ///< Null without one.
};

/// Whether some of the mesh is out of sight, or has a tolerance of its own,
bool has_outside(const TetraMeshOptions& wanted) {
  return wanted.query.max_error_outside || wanted.query.view;
}
/// and whether some of it may be left out, by a threshold or regions.
bool is_left_out(const TetraMeshOptions& wanted) {
  return wanted.threshold || !wanted.regions.empty();
}

Json picture_json(const TetraPictureJob& job, const TetraInput& input, const TetraPictures& told) {
  const auto& [plan, made, path] = told;
  const TetraFieldInfo& field = input.field();
  Json json;
  json["command"] = "render";
  json["input"] = job.input;
  json["outputs"] = outputs_of(job);
  json["model"] = "tetra_mt";
  json["field"] = field.name;
  json["color_by"] = job.picture.color_by.empty() ? Json(nullptr) : Json(job.picture.color_by);
  json["color_range"] = {plan.shown.colors.low, plan.shown.colors.high};
  json["max_error"] = max_error_json(made.mesh.max_error);
  json["achieved_error"] = made.mesh.achieved_error;
  if (!job.picture.query.opacity.empty()) json["opacity"] = job.picture.query.opacity;
  json["largest_error"] = made.mesh.largest_error;
  json["error_kind"] = name_of(field.error_place);
  json["cells"] = made.mesh.n_cells;
  json["reference_cells"] = input.dataset.describe().n_cells;
  json["triangles"] = made.picture.n_triangles;
  json["section_triangles"] = made.picture.n_section_triangles;
  json["boundary_triangles"] = made.picture.n_boundary_triangles;
  json["lines"] = made.picture.n_lines;
  if (is_left_out(plan.wanted)) json["left_out"] = made.mesh.n_left_out;
  json["budget_met"] = made.mesh.budget_met;
  json["is_settled"] = made.mesh.is_settled;
  if (made.warped) json["inverted_cells"] = made.warped->n_inverted;
  json["camera"] = camera_json(made.picture.camera);
  if (!path.is_null()) json["camera_path"] = path;
  json["seconds"] = {
      {"open", input.seconds}, {"extract", made.mesh.seconds}, {"render", made.picture.seconds}};
  return json;
}

Outcome picture_outcome(const TetraPictureJob& job, const TetraInput& input,
                        const TetraPictures& told, const Session& session) {
  const auto& [plan, made, path] = told;
  const TetraFieldInfo& field = input.field();
  Outcome outcome{.json = picture_json(job, input, told), .text = {}};
  Table table;
  table.add(
      {"field", fmt::format("{}, {}", field.name, format_range(field.range_min, field.range_max))});
  if (!job.picture.color_by.empty())
    table.add({"colours", fmt::format("{}, {} to {}", job.picture.color_by,
                                      format_number(plan.shown.colors.low),
                                      format_number(plan.shown.colors.high))});
  add_reading(input, table, outcome.json);
  table.add({"max error", describe_max_error(made.mesh.max_error)});
  table.add({"achieved error", format_number(made.mesh.achieved_error) + ' ' +
                                   name_of(field.error_place) +
                                   (job.picture.query.opacity.empty() ? "" : kWhereShown)});
  add_space_error(job.query(), {made.mesh.achieved_world_error, made.mesh.achieved_px}, table,
                  outcome.json);
  if (has_outside(plan.wanted))
    table.add({"error anywhere",
               format_number(made.mesh.largest_error) + ' ' + name_of(field.error_place)});
  add_deadline(made.mesh.is_settled, table);
  add_warp(made.warped, table, outcome.json);
  table.add({"cells", fmt::format("{} of {}", format_count(made.mesh.n_cells),
                                  format_count(input.dataset.describe().n_cells))});
  if (is_left_out(plan.wanted)) table.add({"cells left out", format_count(made.mesh.n_left_out)});
  if (made.picture.n_triangles > 0)
    table.add({"triangles", format_count(made.picture.n_triangles)});
  if (made.picture.n_boundary_triangles > 0)
    table.add({"triangles of boundary", format_count(made.picture.n_boundary_triangles)});
  if (made.picture.n_section_triangles > 0)
    table.add({"triangles of sections", format_count(made.picture.n_section_triangles)});
  table.add({"size", fmt::format("{}x{} pixels", job.options.width, job.options.height)});
  table.add({input.was_built() ? "read and build" : "open", format_seconds(input.seconds)});
  table.add({"extract", format_seconds(made.mesh.seconds)});
  table.add({"render", format_seconds(made.picture.seconds)});
  if (!path.is_null()) add_tetra_path(job, path, table);
  for (const std::string& output : outputs_of(job)) table.add({"output", output});
  outcome.text = table.to_string();
  outcome.json["warnings"] = session.warnings();
  return outcome;
}

/// That something is coloured by what is told, and not otherwise.
Result<void> check_colors(const TetraPictureJob& job) {
  const TetraPictureArguments& picture = job.picture;
  const bool has_surfaces =
      job.is_default() || picture.boundary == "field" || !picture.query.sections.empty();
  const bool has_isosurfaces = !job.extraction.isovalues.empty();
  if (!picture.color_by.empty() && !has_surfaces && !has_isosurfaces)
    return fail("--color-by: expected --isovalue, --section or --boundary=field with it");
  if (!picture.color_by.empty() && job.reading.field.empty() && !is_lode_path(job.input))
    return fail("--color-by: expected --field with it, got none");
  if (!picture.color_by.empty() && job.options.color)
    return fail("--color-by: expected no --color with it, which isosurfaces cannot have, too");
  if (picture.color_range.empty()) return {};
  LODE_TRY(const Range range, parse_range("--color-range", picture.color_range));
  if (!(range.low < range.high) || !std::isfinite(range.high - range.low))
    return fail("--color-range: expected a smaller and a larger value, got {}",
                picture.color_range);
  const std::string& opacity = picture.query.opacity;
  if (picture.color_by.empty() && !opacity.empty() && !is_transfer_preset(opacity))
    return fail(
        "--color-range: expected a preset of --opacity with it, as a file has values of "
        "its own, got {}",
        opacity);
  if (picture.color_by.empty() && !has_surfaces && opacity.empty())
    return fail(
        "--color-range: expected --section, --boundary=field, --opacity or --color-by with "
        "it, whose colours it is of");
  return {};
}

}  // namespace

void add_tetra_picture_options(CLI::App& app, TetraPictureArguments& arguments) {
  add_warp_options(app, arguments.query.warp);
  const auto add = [&](const char* name, auto& value, const char* type, const char* help) {
    app.add_option(name, value, help)
        ->type_name(type)
        ->allow_extra_args(false)
        ->group("Meshes of cells");
  };
  add("--opacity", arguments.query.opacity, "PRESET|FILE",
      "Direct volume rendering: viridis-smoke, smoke, bands, solid, clear-middle, or a file of "
      "lines 'value red green blue extinction'; the tolerance holds where the extinction is the "
      "largest, elsewhere errors count in proportion");
  add("--section", arguments.query.sections, "A,B,C,D",
      "Show the plane A x + B y + C z = D, or X,Y,Z:NX,NY,NZ; may be repeated");
  const auto add_flag = [&](const char* name, bool& value, const char* help) {
    app.add_flag(name, value, help)->group("Meshes of cells");
  };
  app.add_flag("--boundary{film}", arguments.boundary,
               "Show the mesh's boundary as a thin film; =field: opaque, coloured by the field "
               "(default, where nothing else is asked for)")
      ->group("Meshes of cells");
  add("--legend", arguments.legend, "on|off",
      "A bar of the colours of the field, with values (default: on, in pictures of at least "
      "320x240 that have such colours)");
  add("--color-by", arguments.color_by, "NAME",
      "Isosurfaces, sections and the boundary have the colours of another field, of the same cells "
      "(the .lode file must have been built --with it)");
  add("--color-range", arguments.color_range, "A:B",
      "Values of the first and the last colour (default: the range of the field, in which presets "
      "of --opacity lie, too)");
  add_flag("--wireframe", arguments.has_wireframe, "Show all edges of the mesh");
  add_flag("--points", arguments.has_points, "Show all vertices of the mesh");
  add_focus_options(app, arguments.query);
}

Result<void> check_tetra_picture(const TetraPictureJob& job) {
  LODE_CHECK(check_warp(job.query()));
  LODE_CHECK(check_path_and_frames(job.path, outputs_of(job)));
  // Where a path's cameras are does not matter yet, but that there are some.
  LODE_TRY(const std::vector<Camera> cameras, path_cameras(job, {{{0, 0, 0}}, {{1, 1, 1}}}));
  LODE_TRY(const std::optional<Camera> camera, picture_camera(job, cameras));
  LODE_TRY(const TetraPicturePlan plan, check_picture_plan(job, camera));
  if (!job.reading.with.empty() && !job.picture.query.warp.is_wanted())
    return fail("--with: expected none with a picture, which shows one field, got {}",
                job.reading.with.front());
  const std::string& boundary = job.picture.boundary;
  if (!boundary.empty() && boundary != "film" && boundary != "field")
    return fail("--boundary: expected film or field, got '{}'", boundary);
  if (job.options.color && plan.shown.isovalues.empty())
    return fail("--color: expected --isovalue with it, whose surfaces have it");
  LODE_CHECK(check_colors(job));
  const std::string& legend = job.picture.legend;
  if (!legend.empty() && legend != "on" && legend != "off")
    return fail("--legend: expected on or off, got '{}'", legend);
  LODE_CHECK(check_extension(job.output, ".png"));
  LODE_CHECK(check_tetra_reading(job.reading, job.input));
  LODE_CHECK(check_opacity(job.picture.query.opacity));
  std::vector<std::string> inputs = files_of(job.picture.query);
  inputs.push_back(job.input);
  if (!job.camera.empty()) inputs.push_back(job.camera);
  if (job.path.is_wanted()) inputs.push_back(job.path.path);
  return check_paths_differ(inputs, outputs_of(job));
}

Result<Outcome> run_tetra_picture(const TetraPictureJob& job, Session& session) {
  for (const std::string& path : outputs_of(job)) LODE_CHECK(check_writable(path));
  LODE_TRY(OutputFolder folder, OutputFolder::make(job.path.frames));
  LODE_TRY(
      const TetraInput input,
      open_tetra_input(job.input, reading_for(job.reading_with_colors(), job.query()), session));
  LODE_CHECK(check_space_errors(job.input, input.field(), job.query()));
  LODE_TRY(const std::vector<Camera> cameras, path_cameras(job, input.dataset.describe().bounds));
  LODE_TRY(const std::optional<Camera> camera, picture_camera(job, cameras));
  LODE_TRY(const TetraPicturePlan plan, plan_picture(job, input, camera, session));
  if (job.is_default()) session.note("nothing to show was named: --boundary=field");
  OutputSet outputs(outputs_of(job));
  Json path;
  if (!cameras.empty()) {
    LODE_TRY(path, draw_tetra_path({job, plan, cameras, folder, input}, session, outputs));
  }
  TetraSession questions(input.dataset);
  LODE_TRY(const TetraPicture made, draw_picture(job, input, plan, camera, questions, session));
  for (const std::string& message : made.warnings) session.warn(message);
  LODE_CHECK(write_png(made.image, job.output));
  outputs.add(job.output);
  if (!job.save_camera.empty()) LODE_CHECK(write_camera(made.picture.camera, job.save_camera));
  outputs.keep();
  folder.keep();
  return picture_outcome(job, input, {plan, made, path}, session);
}

}  // namespace lode::cli
