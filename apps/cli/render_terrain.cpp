#include "render_terrain.h"

#include "extract_terrain.h"
#include "outputs.h"
#include "parse.h"
#include "render_tetra.h"
#include "stopwatch.h"
#include "terrain_facts.h"
#include "terrain_focus_options.h"
#include "terrain_query.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

Result<std::optional<double>> to_positive(const char* option, const std::string& text) {
  if (text.empty()) return std::optional<double>();
  LODE_TRY(const double number, parse_number(option, text));
  if (!(number > 0)) return fail("{}: expected a number > 0, got '{}'", option, text);
  return std::optional(number);
}

Result<TerrainPictureOptions> to_options(const TerrainPictureJob& job) {
  TerrainPictureOptions options;
  LODE_TRY(options.terrain, to_terrain_options(job.max_error, job.max_cells, job.picture.terrain));
  LODE_TRY(options.exaggeration, to_positive("--exaggeration", job.picture.exaggeration));
  LODE_TRY(options.contour_interval, to_positive("--contours", job.picture.contours));
  if (!job.max_error_px.empty()) {
    LODE_TRY(options.max_error_px, parse_number("--max-error-px", job.max_error_px));
    if (*options.max_error_px < 0)
      return fail("--max-error-px: expected a number >= 0, got '{}'", job.max_error_px);
  }
  options.is_from_above = job.picture.is_from_above;
  options.render = job.options;
  return options;
}

std::vector<std::string> outputs_of(const TerrainPictureJob& job) {
  if (job.save_camera.empty()) return {job.output};
  return {job.output, job.save_camera};
}

bool is_default(const TerrainPictureJob& job) {
  return job.max_error.empty() && job.max_cells.empty();
}

/// Pixels have a bound where something that is asked for a view can vary.
Result<void> check_pixels(const TerrainPictureJob& job) {
  if (job.max_error_px.empty()) return {};
  if (!job.max_cells.empty()) return fail("--max-error-px: expected no --max-cells with it");
  LODE_TRY(const auto building, to_build_options(job.picture.terrain, {}));
  if (holds_terrain_model(job.input) || (building && may_vary(building->model))) return {};
  return fail(
      "{}: expected one tolerance for all of a terrain, got --max-error-px: --model "
      "delaunay_pyramid can vary, of rasters right_triangle_bisection and others too, and so can a "
      ".lode file that `lode build` makes",
      job.input);
}

void add_pixels(const TerrainPictureReport& report, Json& json, Table& table) {
  const auto& view = report.terrain.view;
  json["max_error_px"] = view ? Json(*view->max_error_px) : Json(nullptr);
  json["achieved_px"] = view ? Json(view->achieved_px) : Json(nullptr);
  if (!view) return;
  table.add({"max error", format_number(*view->max_error_px) + " pixels"});
  table.add({"achieved in view", describe_achieved(view->achieved_px)});
}

std::string describe_extent(double metres) {
  return metres >= 1e4 ? fmt::format("{} km", format_number(metres / 1e3))
                       : fmt::format("{} m", format_number(metres));
}

Outcome outcome_of(const TerrainPictureJob& job, const OpenedTerrain& opened,
                   const TerrainPictureReport& report, double read_seconds,
                   const Session& session) {
  Outcome outcome;
  Json& json = outcome.json;
  Table table;
  json["command"] = "render";
  json["input"] = job.input;
  json["outputs"] = outputs_of(job);
  add_facts(opened.facts, json, table);
  json["model"] = name_of(opened.model);
  // In pixels nothing is promised of heights, unless that was asked for.
  const bool has_tolerance = job.max_error_px.empty() || !job.max_error.empty();
  json["max_error"] = has_tolerance ? Json(report.terrain.max_error) : Json(nullptr);
  json["max_error_is_default"] = is_default(job);
  json["achieved_error"] = report.terrain.achieved_error;
  json["error_met"] = report.terrain.is_within_error;
  json["error_kind"] = "at samples";
  json["triangles"] = report.terrain.triangles;
  json["exaggeration"] = report.exaggeration;
  json["exaggeration_is_default"] = job.picture.exaggeration.empty();
  json["extent_metres"] = {report.width, report.depth};
  json["contours"] = report.n_contours;
  json["size"] = fmt::format("{}x{}", job.options.width, job.options.height);
  json["camera"] = camera_json(report.camera);
  json["seconds"] = {{"total", read_seconds + report.seconds},
                     {"read", read_seconds},
                     {"select", report.terrain.seconds},
                     {"render", report.seconds - report.terrain.seconds}};
  json["warnings"] = session.warnings();
  table.add({"extent", describe_extent(report.width) + " x " + describe_extent(report.depth)});
  add_pixels(report, json, table);
  if (has_tolerance)
    table.add({"max error", format_number(report.terrain.max_error) +
                                (is_default(job) ? " (default: a quarter of a pixel)" : "")});
  table.add({"achieved error", format_number(report.terrain.achieved_error) + " at samples" +
                                   (job.max_error_px.empty() ? "" : ", seen or not")});
  table.add({"triangles", format_count(report.terrain.triangles)});
  table.add({"heights", fmt::format("{} times{}", format_number(report.exaggeration),
                                    job.picture.exaggeration.empty() ? " (default)" : "")});
  if (!job.picture.contours.empty())
    table.add({"contours", fmt::format("{} lines", format_count(report.n_contours))});
  table.add({"size", json["size"].get<std::string>() + " pixels"});
  table.add({"read", format_seconds(read_seconds)});
  table.add({"select", format_seconds(report.terrain.seconds)});
  table.add({"render", format_seconds(report.seconds - report.terrain.seconds)});
  for (const std::string& path : outputs_of(job)) table.add({"output", path});
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace

void add_terrain_picture_options(CLI::App& app, TerrainPictureArguments& arguments) {
  const char* group = "Terrain";
  add_terrain_options(app, arguments.terrain, TerrainUse::extraction);
  app.add_option("--exaggeration", arguments.exaggeration,
                 "Heights count so many times (default: 1, or as it takes to see the relief)")
      ->type_name("X")
      ->group(group);
  app.add_option("--contours", arguments.contours, "Contour lines at multiples of so much")
      ->type_name("INTERVAL")
      ->group(group);
  app.add_flag("--top", arguments.is_from_above, "From above, as a map, north up")->group(group);
}

Result<void> check_no_terrain_picture(const TerrainPictureArguments& arguments,
                                      const std::string& path) {
  LODE_CHECK(check_no_terrain(arguments.terrain, path));
  if (arguments.is_empty()) return {};
  return fail("{}: expected {} with --exaggeration, --contours or --top, got another file", path,
              kTerrainFiles);
}

Result<void> check_terrain_picture(const TerrainPictureJob& job, const CLI::App& app) {
  LODE_CHECK(
      check_only_terrain(app, job.input,
                         {"--max-error", "--max-cells", "--model", "--insertion", "--exaggeration",
                          "--contours", "--top", "--size", "--camera", "--save-camera", "--color",
                          "--background", "--samples", "--max-error-px"}));
  LODE_CHECK(check_terrain_model(job.input, job.picture.terrain, job.reading));
  LODE_CHECK(check_extension(job.output, ".png"));
  if (auto options = to_options(job); !options) return options.error();
  LODE_CHECK(check_pixels(job));
  LODE_CHECK(check_terrain_reading(job.input, job.picture.terrain, job.reading));
  if (job.picture.is_from_above && !job.camera.empty())
    return fail("--top: expected no --camera with it, got {}", job.camera);
  return check_paths_differ(
      job.camera.empty() ? std::vector{job.input} : std::vector{job.input, job.camera},
      outputs_of(job));
}

Result<Outcome> run_terrain_picture(const TerrainPictureJob& job, Session& session) {
  LODE_TRY(TerrainPictureOptions options, to_options(job));
  // Pixels may take any tolerance.
  const std::optional<double> all{0};
  LODE_TRY(auto building, to_build_options(job.picture.terrain,
                                           options.max_error_px ? all : options.terrain.max_error));
  if (building && options.max_error_px) choose_levels(options.terrain.max_error, *building);
  options.render.threads = session.threads();
  options.terrain.threads = session.threads();
  if (!job.camera.empty()) {
    LODE_TRY(options.render.camera, read_camera(job.camera));
  }
  for (const std::string& path : outputs_of(job)) LODE_CHECK(check_writable(path));
  const Stopwatch watch;
  LODE_TRY(const OpenedTerrain opened, open_terrain(job.input, job.picture.terrain, job.reading,
                                                    building, options.terrain.max_error, session,
                                                    {.has_shares = is_share(job.max_error)}));
  set_share(job.max_error, opened.terrain.range(), options.terrain.max_error);
  LODE_CHECK(check_upwards(opened.facts.frame, job.input));
  LODE_TRY(const HorizontalMetric metric,
           naming(job.input, read_metric(opened.facts.frame.crs), session));
  const double read_seconds = watch.seconds();
  TerrainPictureReport report;
  LODE_TRY(
      const Image image,
      naming(job.input, draw_terrain(opened.terrain, metric, options, report, session.progress()),
             session));
  if (const auto& view = report.terrain.view)
    warn_of_view(*view, opened.model, opened.terrain.origin().finest_error(), session);
  warn_of_unit(report.is_vertical_unit_known, opened.facts.frame, metric, job.input, session);
  OutputSet outputs(outputs_of(job));
  LODE_CHECK(write_png(image, job.output));
  outputs.add(job.output);
  if (!job.save_camera.empty()) LODE_CHECK(write_camera(report.camera, job.save_camera));
  outputs.keep();
  return outcome_of(job, opened, report, read_seconds, session);
}

}  // namespace lode::cli
