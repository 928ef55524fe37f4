#include "render_tetra.h"

#include <cmath>

#include "outputs.h"
#include "parse.h"
#include "query_options.h"
#include "stopwatch.h"
#include "tetra_input.h"
#include "text.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

constexpr double kBoundaryOpacity = 0.12;
constexpr double kWireWidth = 1;
constexpr int kVolumeSamples = 4;  // A volume alone has soft edges but for its border.

/// A point and a normal as elsewhere, or A,B,C,D: where A x + B y + C z = D.
Result<SectionPlane> parse_plane(const std::string& text) {
  SectionPlane plane;
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos) {
    LODE_TRY(plane.point, parse_vector("--section", text.substr(0, colon)));
    LODE_TRY(plane.normal, parse_vector("--section", text.substr(colon + 1)));
  } else {
    LODE_TRY(const auto n, parse_numbers("--section", text));
    if (n.size() != 4)
      return fail("--section: expected a plane as A,B,C,D or X,Y,Z:NX,NY,NZ, got '{}'", text);
    plane.normal = {{n[0], n[1], n[2]}};
    plane.point = plane.normal * (n[3] / dot(plane.normal, plane.normal));
  }
  for (const double number : plane.point.v)
    if (!std::isfinite(number)) return fail("--section: expected a normal, got '{}'", text);
  if (!(length(plane.normal) > 0) || !std::isfinite(length(plane.normal)))
    return fail("--section: expected a normal whose length is a number above 0, got '{}'", text);
  return plane;
}

/// What of the mesh is wanted, and what is shown.
Result<Query> to_query(const TetraPictureJob& job, const MeshPictureOptions& picture) {
  LODE_TRY(const QueryArguments arguments, without_share(job.picture.query));
  LODE_TRY(MeshOptions typed, to_mesh_options(arguments, job.extraction, "mesh of cells"));
  const Query shown = query_of(picture);
  Query query = std::move(typed.query);
  query.isovalues = shown.isovalues;
  query.opacity = shown.opacity;
  query.sections = shown.sections;
  return query;
}

/// But for the transfer function, which may need the mesh.
Result<MeshPictureOptions> to_picture(const TetraPictureJob& job) {
  MeshPictureOptions options;
  LODE_TRY(const ExtractOptions extraction, to_extract_options(job.extraction));
  options.render = job.options;
  if (job.is_default_samples && extraction.isovalues.empty() && job.picture.sections.empty() &&
      !job.picture.has_wireframe && !job.picture.has_points)
    options.render.samples_per_pixel = kVolumeSamples;
  options.isovalues = extraction.isovalues;
  options.has_wireframe = job.picture.has_wireframe;
  options.has_points = job.picture.has_points;
  options.boundary_opacity = job.picture.has_boundary ? kBoundaryOpacity : 0;
  if (options.has_wireframe) options.render.line_width_px = kWireWidth;
  for (const std::string& text : job.picture.sections) {
    LODE_TRY(const SectionPlane plane, parse_plane(text));
    options.sections.push_back(plane);
  }
  return options;
}

std::vector<std::string> outputs_of(const TetraPictureJob& job) {
  return job.save_camera.empty() ? std::vector{job.output}
                                 : std::vector{job.output, job.save_camera};
}

/// How the picture came to be.
struct TetraPicture {
  MeshReport mesh;
  MeshPictureReport picture;
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
  json["max_error"] = made.mesh.max_error;
  json["achieved_error"] = made.mesh.achieved_error;
  if (!job.picture.opacity.empty()) json["opacity"] = job.picture.opacity;
  json["largest_error"] = made.mesh.largest_error;
  json["error_kind"] = name_of(field.error_place);
  json["cells"] = made.mesh.n_cells;
  json["reference_cells"] = info.n_cells;
  json["triangles"] = made.picture.n_triangles;
  json["section_triangles"] = made.picture.n_section_triangles;
  json["lines"] = made.picture.n_lines;
  json["budget_met"] = made.mesh.budget_met;
  json["camera"] = camera_json(made.picture.camera);
  json["seconds"] = {
      {"open", input.seconds}, {"extract", made.mesh.seconds}, {"render", made.picture.seconds}};
  Table table;
  table.add({"field", fmt::format("{}, {} to {}", field.name, format_number(field.range_min),
                                  format_number(field.range_max))});
  add_reading(input, table, json);
  table.add({"max error", format_number(made.mesh.max_error)});
  table.add({"achieved error", format_number(made.mesh.achieved_error) + ' ' +
                                   name_of(field.error_place) +
                                   (job.picture.opacity.empty() ? "" : kWhereShown)});
  if (!job.picture.query.max_error_outside.empty())
    table.add({"error anywhere",
               format_number(made.mesh.largest_error) + ' ' + name_of(field.error_place)});
  table.add({"cells",
             fmt::format("{} of {}", format_count(made.mesh.n_cells), format_count(info.n_cells))});
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
  if (!job.picture.opacity.empty()) {
    LODE_TRY(options.opacity,
             to_transfer_function(job.picture.opacity, info.bounds, options.colors));
    if (options.colors.low == options.colors.high)
      session.warn(fmt::format("the field has one value, {}: its volume has one colour, or none",
                               format_number(options.colors.low)));
  }
  LODE_TRY(Query query, to_query(job, options));
  set_share(job.extraction.max_error, input.field().range_min, input.field().range_max,
            query.max_error);
  set_share(job.picture.query.max_error_outside, input.field().range_min, input.field().range_max,
            query.max_error_outside);
  if (!job.camera.empty()) {
    LODE_TRY(options.render.camera, read_camera(job.camera));
  }
  options.render.threads = session.threads();
  auto regions = find_regions(info, job.picture.query.regions);
  if (!regions) return fail("{}: {}", job.input, regions.error().message);
  TetraPicture made;
  SimplexMesh mesh;
  LODE_TRY(made.mesh, input.dataset.extract_mesh({.query = query,
                                                  .threshold = {},
                                                  .regions = std::move(*regions),
                                                  .threads = session.threads(),
                                                  .fields = input.fields},
                                                 mesh, session.progress()));
  if (!made.mesh.budget_met)
    session.warn(fmt::format("--max-cells is not met: the coarsest mesh has {} simplices",
                             made.mesh.n_cut_cells));
  LODE_TRY(const std::uint64_t n_inverted,
           apply_warp(job.picture.warp, job.reading, session.threads(), mesh));
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
  add_warp_options(app, arguments.warp);
  const auto add = [&](const char* name, auto& value, const char* type, const char* help) {
    app.add_option(name, value, help)
        ->type_name(type)
        ->allow_extra_args(false)
        ->group("Meshes of cells");
  };
  add("--opacity", arguments.opacity, "PRESET|FILE",
      "Direct volume rendering: viridis-smoke, smoke, bands, solid, clear-middle, or a file of "
      "lines 'value red green blue extinction'; the tolerance holds where the extinction is the "
      "largest, elsewhere errors count in proportion");
  add("--section", arguments.sections, "A,B,C,D",
      "Show the plane A x + B y + C z = D, or X,Y,Z:NX,NY,NZ; may be repeated");
  const auto add_flag = [&](const char* name, bool& value, const char* help) {
    app.add_flag(name, value, help)->group("Meshes of cells");
  };
  add_flag("--boundary", arguments.has_boundary, "Show the mesh's boundary as a thin film");
  add_flag("--wireframe", arguments.has_wireframe, "Show all edges of the mesh");
  add_flag("--points", arguments.has_points, "Show all vertices of the mesh");
  add("--max-cells", arguments.query.max_cells, "N",
      "At most N tetrahedra; without --max-error, as accurate as they allow");
  add("--region", arguments.query.regions, "NAME",
      "Show only cells of a region (block, material, zone), by its name or number, and be accurate "
      "in these alone: --max-cells counts the whole mesh, most of it spent there; may be repeated");
  add("--field-range", arguments.query.field_ranges, "A:B",
      "Accurate where the field may be from A to B; may be repeated");
  add("--box", arguments.query.boxes, "X0,X1,Y0,Y1,Z0,Z1",
      "Accurate in a box; may be repeated (crops nothing)");
  add("--ball", arguments.query.balls, "X,Y,Z,R", "Accurate in a ball; may be repeated");
  add("--half-space", arguments.query.half_spaces, "X,Y,Z:NX,NY,NZ",
      "Accurate on the side of a plane that its normal points to; may be repeated");
  add("--max-error-outside", arguments.query.max_error_outside, "E",
      "Tolerance outside of these, likewise in field units or with % (default: any)");
}

Result<void> check_tetra_picture(const TetraPictureJob& job) {
  LODE_CHECK(check_warp(job.picture.warp));
  LODE_TRY(const MeshPictureOptions options, to_picture(job));
  LODE_CHECK(to_query(job, options));
  if (!job.reading.with.empty() && !job.picture.warp.is_wanted())
    return fail("--with: expected none with a picture, which shows one field, got {}",
                job.reading.with.front());
  if (options.isovalues.empty() && !job.picture.is_of_mesh())
    return fail(
        "{}: expected --isovalue, --opacity, --section, --boundary, --wireframe or --points, got "
        "none",
        job.input);
  LODE_CHECK(check_extension(job.output, ".png"));
  LODE_CHECK(check_tetra_reading(job.reading, job.input));
  std::vector<std::string> inputs{job.input};
  if (!job.camera.empty()) inputs.push_back(job.camera);
  LODE_CHECK(check_opacity(job.picture.opacity));
  if (!job.picture.opacity.empty() && !is_transfer_preset(job.picture.opacity))
    inputs.push_back(job.picture.opacity);
  return check_paths_differ(inputs, outputs_of(job));
}

Result<Outcome> run_tetra_picture(const TetraPictureJob& job, Session& session) {
  for (const std::string& path : outputs_of(job)) LODE_CHECK(check_writable(path));
  LODE_TRY(const TetraInput input,
           open_tetra_input(job.input, with_warp(job.reading, job.picture.warp), session));
  LODE_TRY(const TetraPicture made, draw_picture(job, input, session));
  return picture_outcome(job, input, made, session);
}

}  // namespace lode::cli
