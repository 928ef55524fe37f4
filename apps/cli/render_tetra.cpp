#include "render_tetra.h"

#include <utility>

#include "outputs.h"
#include "stopwatch.h"
#include "tetra_input.h"
#include "tetra_query_options.h"
#include "text.h"

namespace lode::cli {
namespace {

constexpr double kBoundaryOpacity = 0.12;
constexpr double kWireWidth = 1;
constexpr int kVolumeSamples = 4;  // A volume alone has soft edges but for its border.

/// Without another, the view is that of the picture's camera: what it does not show may be coarse.
/// Not of a deformed mesh, whose cells are where the hierarchy does not know.
QueryArguments with_own_view(const TetraPictureJob& job) {
  QueryArguments arguments = job.picture.query;
  arguments.max_error_px = job.max_error_px;
  if (!arguments.view.empty() || job.camera.empty() || arguments.warp.is_wanted()) return arguments;
  arguments.view = job.camera;
  arguments.view_size = fmt::format("{}x{}", job.options.width, job.options.height);
  return arguments;
}

/// What of the mesh is wanted, and what is shown.
Result<TetraMeshOptions> to_picture_query(const TetraPictureJob& job,
                                          const MeshPictureOptions& picture) {
  LODE_CHECK(check_view_size(job.picture.query));
  LODE_TRY(TetraMeshOptions options,
           to_tetra_query(with_own_view(job), job.extraction, "mesh of cells"));
  Query shown = query_of(picture);
  options.query.isovalues = std::move(shown.isovalues);
  options.query.opacity = std::move(shown.opacity);
  options.query.sections = std::move(shown.sections);
  LODE_CHECK(check_outside(options.query));
  return options;
}

/// But for what the transfer function is, which may need the mesh.
Result<MeshPictureOptions> to_picture(const TetraPictureJob& job) {
  MeshPictureOptions options;
  LODE_TRY(const ExtractOptions extraction, to_extract_options(job.extraction));
  options.render = job.options;
  if (job.is_default_samples && extraction.isovalues.empty() &&
      job.picture.query.sections.empty() && !job.picture.has_wireframe && !job.picture.has_points)
    options.render.samples_per_pixel = kVolumeSamples;
  options.isovalues = extraction.isovalues;
  options.has_wireframe = job.picture.has_wireframe;
  options.has_points = job.picture.has_points;
  options.boundary_opacity = job.picture.has_boundary ? kBoundaryOpacity : 0;
  if (options.has_wireframe) options.render.line_width_px = kWireWidth;
  LODE_TRY(options.sections, to_planes(job.picture.query));
  if (!job.picture.query.opacity.empty()) options.opacity = TransferFunction{{TransferKnot{}}};
  return options;
}

std::vector<std::string> outputs_of(const TetraPictureJob& job) {
  return job.save_camera.empty() ? std::vector{job.output}
                                 : std::vector{job.output, job.save_camera};
}

/// How the picture came to be.
struct TetraPicture {
  MeshReport mesh{};
  MeshPictureReport picture{};
  bool has_outside = false;  ///< Some of the mesh is out of sight, or has a tolerance of its own.
  bool is_left_out = false;  ///< Some of it may be, by a threshold or regions.
};

Outcome picture_outcome(const TetraPictureJob& job, const TetraInput& input,
                        const TetraPicture& made, const Session& session) {
  const TetraInfo& info = input.dataset.describe();
  const TetraFieldInfo& field = input.field();
  Outcome outcome;
  Json& json = outcome.json;
  json["command"] = "render";
  json["input"] = job.input;
  json["outputs"] = outputs_of(job);
  json["model"] = "tetra_mt";
  json["field"] = field.name;
  json["max_error"] = max_error_json(made.mesh.max_error);
  json["achieved_error"] = made.mesh.achieved_error;
  if (!job.picture.query.opacity.empty()) json["opacity"] = job.picture.query.opacity;
  json["largest_error"] = made.mesh.largest_error;
  json["error_kind"] = name_of(field.error_place);
  json["cells"] = made.mesh.n_cells;
  json["reference_cells"] = info.n_cells;
  json["triangles"] = made.picture.n_triangles;
  json["section_triangles"] = made.picture.n_section_triangles;
  json["lines"] = made.picture.n_lines;
  if (made.is_left_out) json["left_out"] = made.mesh.n_left_out;
  json["budget_met"] = made.mesh.budget_met;
  json["is_settled"] = made.mesh.is_settled;
  json["camera"] = camera_json(made.picture.camera);
  json["seconds"] = {
      {"open", input.seconds}, {"extract", made.mesh.seconds}, {"render", made.picture.seconds}};
  Table table;
  table.add({"field", fmt::format("{}, {} to {}", field.name, format_number(field.range_min),
                                  format_number(field.range_max))});
  add_reading(input, table, json);
  table.add({"max error", describe_max_error(made.mesh.max_error)});
  table.add({"achieved error", format_number(made.mesh.achieved_error) + ' ' +
                                   name_of(field.error_place) +
                                   (job.picture.query.opacity.empty() ? "" : kWhereShown)});
  add_space_error(with_own_view(job), {made.mesh.achieved_world_error, made.mesh.achieved_px},
                  table, json);
  if (made.has_outside)
    table.add({"error anywhere",
               format_number(made.mesh.largest_error) + ' ' + name_of(field.error_place)});
  add_deadline(made.mesh.is_settled, table);
  table.add({"cells",
             fmt::format("{} of {}", format_count(made.mesh.n_cells), format_count(info.n_cells))});
  if (made.is_left_out) table.add({"cells left out", format_count(made.mesh.n_left_out)});
  if (made.picture.n_triangles > 0)
    table.add({"triangles", format_count(made.picture.n_triangles)});
  if (made.picture.n_section_triangles > 0)
    table.add({"triangles of sections", format_count(made.picture.n_section_triangles)});
  table.add({"size", fmt::format("{}x{} pixels", job.options.width, job.options.height)});
  table.add({input.was_built() ? "read and build" : "open", format_seconds(input.seconds)});
  table.add({"extract", format_seconds(made.mesh.seconds)});
  table.add({"render", format_seconds(made.picture.seconds)});
  for (const std::string& path : outputs_of(job)) table.add({"output", path});
  outcome.text = table.to_string();
  json["warnings"] = session.warnings();
  return outcome;
}

Result<TetraPicture> draw_picture(const TetraPictureJob& job, const TetraInput& input,
                                  Session& session) {
  LODE_TRY(MeshPictureOptions options, to_picture(job));
  const TetraInfo& info = input.dataset.describe();
  options.colors = {input.field().range_min, input.field().range_max};
  if (!job.picture.query.opacity.empty()) {
    LODE_TRY(options.opacity,
             to_transfer_function(job.picture.query.opacity, info.bounds, options.colors));
    if (options.colors.low == options.colors.high)
      session.warn(fmt::format("the field has one value, {}: its volume has one colour, or none",
                               format_number(options.colors.low)));
  }
  LODE_TRY(TetraMeshOptions wanted, to_picture_query(job, options));
  set_shares(job.extraction, job.picture.query, input.field(), wanted.query);
  if (!job.camera.empty()) {
    LODE_TRY(options.render.camera, read_camera(job.camera));
  }
  options.render.threads = wanted.threads = session.threads();
  LODE_TRY(wanted.regions, wanted_regions(job.input, info, job.picture.query));
  wanted.fields = input.fields;
  TetraPicture made{.has_outside = wanted.query.max_error_outside || wanted.query.view,
                    .is_left_out = wanted.threshold || !wanted.regions.empty()};
  SimplexMesh mesh;
  LODE_TRY(made.mesh, input.dataset.extract_mesh(wanted, mesh, session.progress()));
  warn_of_budget(session, made.mesh);
  if (mesh.is_empty())
    session.warn(wanted.threshold ? "the picture is empty: no cell of the cut lies in the threshold"
                                  : "the picture is empty: the mesh has no cell");
  LODE_TRY(const std::uint64_t n_inverted,
           apply_warp(job.picture.query.warp, job.reading, session.threads(), mesh));
  warn_of_inverted(session, n_inverted);
  LODE_TRY(const Image image, draw_mesh(mesh, options, made.picture, session.progress()));
  for (const double isovalue : made.picture.unmet)
    session.warn(fmt::format("no surface at isovalue {}: it meets no cell", isovalue));
  OutputSet outputs(outputs_of(job));
  LODE_CHECK(write_png(image, job.output));
  outputs.add(job.output);
  if (!job.save_camera.empty()) LODE_CHECK(write_camera(made.picture.camera, job.save_camera));
  outputs.keep();
  return made;
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
  add_flag("--boundary", arguments.has_boundary, "Show the mesh's boundary as a thin film");
  add_flag("--wireframe", arguments.has_wireframe, "Show all edges of the mesh");
  add_flag("--points", arguments.has_points, "Show all vertices of the mesh");
  add_focus_options(app, arguments.query);
}

Result<void> check_tetra_picture(const TetraPictureJob& job) {
  LODE_CHECK(check_warp(job.picture.query.warp));
  LODE_TRY(const MeshPictureOptions options, to_picture(job));
  LODE_CHECK(to_picture_query(job, options));
  if (!job.reading.with.empty() && !job.picture.query.warp.is_wanted())
    return fail("--with: expected none with a picture, which shows one field, got {}",
                job.reading.with.front());
  if (options.isovalues.empty() && !job.picture.is_of_mesh())
    return fail(
        "{}: expected --isovalue, --opacity, --section, --boundary, --wireframe or --points, got "
        "none",
        job.input);
  LODE_CHECK(check_extension(job.output, ".png"));
  LODE_CHECK(check_tetra_reading(job.reading, job.input));
  LODE_CHECK(check_opacity(job.picture.query.opacity));
  std::vector<std::string> inputs = files_of(job.picture.query);
  inputs.push_back(job.input);
  if (!job.camera.empty()) inputs.push_back(job.camera);
  return check_paths_differ(inputs, outputs_of(job));
}

Result<Outcome> run_tetra_picture(const TetraPictureJob& job, Session& session) {
  for (const std::string& path : outputs_of(job)) LODE_CHECK(check_writable(path));
  LODE_TRY(const TetraInput input,
           open_tetra_input(job.input, reading_for(job.reading, with_own_view(job)), session));
  LODE_CHECK(check_space_errors(job.input, input.field(), with_own_view(job)));
  LODE_TRY(const TetraPicture made, draw_picture(job, input, session));
  return picture_outcome(job, input, made, session);
}

}  // namespace lode::cli
