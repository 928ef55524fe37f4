#include "terrain_query.h"

#include <cmath>
#include <memory>
#include <numbers>

#include "lode/api/round_terrain.h"
#include "parse.h"
#include "stopwatch.h"
#include "terrain_facts.h"
#include "to_crs.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

ReadingArguments reading_of(const TerrainQueryArguments& arguments) {
  ReadingArguments reading;
  reading.nodata = arguments.nodata;
  return reading;
}

}  // namespace

void add_terrain_source(CLI::App& app, TerrainQueryArguments& arguments, TerrainUse use) {
  app.add_option("dem", arguments.input,
                 "Raster of heights (.tif, .asc, .hgt, .nc, .png, ...), points (.las, .xyz, ...), "
                 "or a .lode file made of these")
      ->type_name("DEM")
      ->required();
  app.add_option("--nodata", arguments.nodata, "Value of missing samples, instead of the file's")
      ->type_name("V")
      ->group("Terrain");
  add_terrain_options(app, arguments.terrain, use);
}

void add_terrain_query(CLI::App& app, TerrainQueryArguments& arguments) {
  add_terrain_source(app, arguments, TerrainUse::extraction);
  app.add_option("--max-error", arguments.max_error,
                 "Tolerance of the TIN in units of the heights, or with % of their range (default: "
                 "0.5%; 0: full resolution)")
      ->type_name("E");
}

void add_distance_crs(CLI::App& app, TerrainQueryArguments& arguments) {
  add_to_crs(app, arguments.terrain,
             "Measure distances in the plane of this CRS, through PROJ, or on its ellipsoid where "
             "it is geographic; places, typed and shown, stay in the CRS of the file");
}

void add_everywhere(CLI::App& app, TerrainQueryArguments& arguments) {
  app.add_flag("--everywhere", arguments.is_everywhere,
               "Bounds hold between samples, too, against full resolution; of rasters, quadtrees, "
               "quaternary triangulations and bisected right triangles, which have all heights at "
               "hand");
}

Result<void> check_terrain_query(const TerrainQueryArguments& arguments,
                                 const std::string& instead) {
  if (!holds_terrain(arguments.input)) {
    if (is_lode_path(arguments.input)) LODE_CHECK(check_lode_opens(arguments.input));
    return fail("{}: expected {}, or a .lode file made of these, got another file{}",
                arguments.input, kTerrainFiles, instead.empty() ? "" : "; " + instead);
  }
  LODE_CHECK(check_terrain_model(arguments.input, arguments.terrain, reading_of(arguments)));
  LODE_CHECK(check_to_crs(arguments.terrain));
  if (auto options = to_terrain_options(arguments.max_error, "", arguments.terrain); !options)
    return options.error();
  return check_terrain_reading(arguments.input, arguments.terrain, reading_of(arguments));
}

Result<TerrainInput> read_terrain(const TerrainQueryArguments& arguments, Session& session) {
  LODE_TRY(TerrainOptions options, to_terrain_options(arguments.max_error, "", arguments.terrain));
  options.threads = session.threads();
  LODE_TRY(const auto building, to_build_options(arguments.terrain, options.max_error));
  const Stopwatch watch;
  LODE_TRY(OpenedTerrain opened,
           open_terrain(arguments.input, arguments.terrain, reading_of(arguments), building,
                        options.max_error, session,
                        {.keeps_samples = arguments.is_everywhere || arguments.may_be_everywhere,
                         .is_closed = arguments.is_closed,
                         .way = arguments.way,
                         .way_crs = arguments.way_crs,
                         .has_shares = is_share(arguments.max_error)}));
  set_share(arguments.max_error, opened.terrain.range(), options.max_error);
  if (arguments.is_everywhere && !opened.samples)
    return fail(
        "{}: expected a raster without lines, or a model that has all heights at hand (the "
        "quadtrees, the quaternary triangulation, right_triangle_bisection), with --everywhere, "
        "got "
        "{}",
        arguments.input,
        opened.built ? std::string("a file or build of ") + name_of(opened.model)
                     : "points, or a raster with lines");
  if (arguments.is_everywhere || arguments.may_be_everywhere) options.samples = opened.samples;
  LODE_TRY(HorizontalMetric metric,
           naming(arguments.input, read_metric(opened.facts.frame.crs), session));
  LODE_TRY(std::optional<TargetCrs> target,
           open_to_crs(arguments.input, arguments.terrain, opened.facts.frame, session));
  if (target) {
    metric.elsewhere = std::make_shared<const HorizontalMetric>(target->metric);
    metric.map = target->map;
  }
  return TerrainInput{std::move(opened), std::move(metric), options, watch.seconds(),
                      std::move(target)};
}

Result<TerrainAnswerer> answer_terrain(const TerrainQueryArguments& arguments, Session& session,
                                       const AcceptTerrain& accept, TinUse use) {
  LODE_TRY(TerrainInput input, read_terrain(arguments, session));
  if (accept) LODE_CHECK(accept(input.opened.facts));
  LODE_TRY(TerrainTin tin, naming(arguments.input,
                                  TerrainTin::select(input.opened.terrain, input.options,
                                                     input.metric, session.progress(), use),
                                  session));
  return TerrainAnswerer{std::move(input.opened), std::move(input.metric), std::move(tin),
                         input.read_seconds, std::move(input.target)};
}

const char* bound_kind_of(const TerrainReport& report) {
  return report.is_everywhere ? "everywhere" : "at samples";
}

void warn_of_unit(bool is_known, const HeightFrame& frame, const HorizontalMetric& metric,
                  const std::string& path, Session& session) {
  if (is_known) return;
  const char* taken =
      metric.assumed_height_unit() == 1 ? "for metres" : "to be in the unit of x and y";
  session.warn(fmt::format(
      "{}: heights are taken {}, as the file {}", path, taken,
      frame.vertical_unit.empty() ? "does not say their unit" : "says a unit that is not known"));
}

void warn_of_long_way(const HorizontalMetric& metric, const HeightFrame& frame, const Place& from,
                      const Place& to, Session& session) {
  if (!metric.ellipsoid) return;
  constexpr double kTurn = 360;
  const double degrees = metric.angle_unit * kTurn / (2 * std::numbers::pi);
  const double way = std::abs(to[0] - from[0]) * degrees;
  const double step = std::abs(frame.to_world[1]) * degrees;
  // First and last samples may be at one place, or a pixel apart.
  const bool is_all_round = (frame.n_columns + 0.5) * step >= kTurn;
  if (!is_all_round || way <= kTurn / 2) return;
  session.warn(fmt::format(
      "the way is straight in the raster's coordinates and goes over {} degrees of longitude; the "
      "other way round the earth, over {}, leaves the raster at its first or last column",
      format_number(way), format_number(kTurn - way)));
}

void add_terrain_head(const TerrainAnswerer& answerer, const TerrainQueryArguments& arguments,
                      Json& json, Table& table) {
  const TerrainReport& report = answerer.tin.report();
  add_facts(answerer.opened.facts, json, table);
  add_lines(answerer.opened, json, table);
  json["model"] = name_of(answerer.opened.model);
  json["max_error"] = report.max_error;
  json["max_error_is_default"] = arguments.max_error.empty();
  json["achieved_error"] = report.achieved_error;
  json["error_kind"] = bound_kind_of(report);
  json["triangles"] = report.triangles;
  table.add({"model", name_of(answerer.opened.model)});
  table.add({"max error", fmt::format("{} ({})", format_number(report.max_error),
                                      arguments.max_error.empty() ? "default: 0.5 % of the range"
                                                                  : "as asked")});
  table.add({"achieved error",
             fmt::format("{} {}", format_number(report.achieved_error), bound_kind_of(report))});
  table.add({"triangles", format_count(report.triangles)});
  table.add({"read", format_seconds(answerer.read_seconds)});
  table.add({"select", format_seconds(report.seconds)});
}

std::string describe_metric(const HorizontalMetric& metric,
                            const std::optional<TargetCrs>& target) {
  const HorizontalMetric& measured = metric.measured();
  const std::string of_target = target ? " of " + target->name : "";
  if (measured.ellipsoid) return "metre, on the ellipsoid " + measured.ellipsoid_name + of_target;
  if (!measured.is_known) return "units of x and y, whose CRS is not known";
  return (measured.unit.empty() ? "units of x and y" : measured.unit) + ", in the plane" +
         (target ? of_target : " of the CRS");
}

void add_metric(const HorizontalMetric& metric, Json& json,
                const std::optional<TargetCrs>& target) {
  const HorizontalMetric& measured = metric.measured();
  json["distance_unit"] = measured.unit.empty() ? Json(nullptr) : Json(measured.unit);
  json["distance_is_planar"] = !measured.ellipsoid.has_value();
  json["ellipsoid"] = measured.ellipsoid ? Json(measured.ellipsoid_name) : Json(nullptr);
  json["distance_crs"] = target ? Json(target->name) : Json(nullptr);
}

Result<Place> parse_place(const std::string& option, const std::string& text) {
  LODE_TRY(const std::vector<double> numbers, parse_numbers(option, text));
  if (numbers.size() != 2) return fail("{}: expected two numbers as X,Y, got '{}'", option, text);
  return Place{{numbers[0], numbers[1]}};
}

void add_segment(CLI::App& app, std::string& from, std::string& to) {
  app.add_option("--from", from, "Where it starts")->type_name("X,Y")->required();
  app.add_option("--to", to, "Where it ends")->type_name("X,Y")->required();
}

Result<void> check_segment(const std::string& from, const std::string& to) {
  LODE_TRY(const Place first, parse_place("--from", from));
  LODE_TRY(const Place last, parse_place("--to", to));
  if (first == last) return fail("--to: expected another place than --from, got '{}' twice", to);
  return {};
}

}  // namespace lode::cli
