#include <fmt/format.h>

#include <memory>

#include "command.h"
#include "parse.h"
#include "places_crs.h"
#include "terrain_facts.h"
#include "terrain_query.h"

namespace lode::cli {
namespace {

struct SightArguments {
  TerrainQueryArguments terrain;
  std::string from;
  std::string to;
  std::string places_crs;
  std::string observer_height = "1.8";
  std::string target_height = "0";
  std::string refraction = "0.13";
  std::string height_unit;
  bool is_exact = false;
};

Result<TerrainSightOptions> to_sight_options(const SightArguments& arguments) {
  TerrainSightOptions options;
  LODE_CHECK(check_segment(arguments.from, arguments.to));
  LODE_TRY(options.from, parse_place("--from", arguments.from));
  LODE_TRY(options.to, parse_place("--to", arguments.to));
  LODE_TRY(options.observer_height, parse_number("--observer-height", arguments.observer_height));
  if (options.observer_height < 0)
    return fail("--observer-height: expected a number >= 0, got '{}'", arguments.observer_height);
  LODE_TRY(options.target_height, parse_number("--target-height", arguments.target_height));
  if (options.target_height < 0)
    return fail("--target-height: expected a number >= 0, got '{}'", arguments.target_height);
  LODE_TRY(options.refraction, parse_number("--refraction", arguments.refraction));
  if (options.refraction > 1)
    return fail("--refraction: expected a number <= 1, at which the earth is flat, got '{}'",
                arguments.refraction);
  if (!arguments.height_unit.empty()) {
    options.vertical_metres = metres_of_unit(arguments.height_unit);
    if (!options.vertical_metres)
      return fail("--height-unit: expected m, ft or us-ft, got '{}'", arguments.height_unit);
  }
  options.effort = arguments.is_exact ? SightEffort::until_decided : SightEffort::once;
  return options;
}

Result<void> check_sight(const SightArguments& arguments) {
  LODE_CHECK(check_terrain_query(arguments.terrain, ""));
  if (auto options = to_sight_options(arguments); !options) return options.error();
  return check_places_crs(arguments.places_crs);
}

const char* verdict_name(SightVerdict verdict) {
  if (verdict == SightVerdict::visible) return "visible";
  return verdict == SightVerdict::blocked ? "blocked" : "undecided";
}

/// Why, in a sentence.
std::string reason_of(const TerrainSight& sight) {
  const auto at = [&] { return fmt::format("at {:.12g}, {:.12g}", sight.at[0], sight.at[1]); };
  if (sight.verdict == SightVerdict::blocked)
    return fmt::format("the terrain stands {} to {} above the ray {}",
                       format_number(sight.above_low), format_number(sight.above_high), at());
  if (sight.has_gap && sight.above_high <= 0)
    return "there are gaps on the way, in which the terrain is not known";
  if (sight.verdict == SightVerdict::visible)
    return fmt::format("the terrain is nearest to the ray {}, {} below it or more", at(),
                       format_number(-sight.above_high));
  return fmt::format("the terrain may stand from {} below the ray to {} above it {}",
                     format_number(-sight.above_low), format_number(sight.above_high), at());
}

/// Of a file that was built for more than no error: nothing finer can decide.
std::string limit_of(const TerrainSight& sight) {
  if (sight.verdict != SightVerdict::undecided || !sight.is_finest() || sight.finest_error == 0)
    return "";
  return fmt::format("; the file has no level finer than {}", format_number(sight.finest_error));
}

Json sight_json(const TerrainSight& sight) {
  Json json;
  json["verdict"] = verdict_name(sight.verdict);
  json["distance"] = sight.distance;
  json["has_gap"] = sight.has_gap;
  json[sight.verdict == SightVerdict::blocked ? "obstruction" : "nearest"] = {
      {"x", sight.at[0]},
      {"y", sight.at[1]},
      {"distance", sight.at_distance},
      {"height", sight.terrain_height},
      {"above_ray_low", sight.above_low},
      {"above_ray_high", sight.above_high}};
  json["rounds"] = sight.n_rounds;
  json["is_finest"] = sight.is_finest();
  json["finest_error"] = sight.finest_error;
  json["max_error"] = sight.terrain.max_error;
  json["achieved_error"] = sight.terrain.achieved_error;
  json["error_kind"] = bound_kind_of(sight.terrain);
  json["triangles"] = sight.terrain.triangles;
  json["earth_radius_metres"] = sight.radius;
  json["metres_of_height_unit"] = sight.vertical_metres;
  json["height_unit_is_known"] = sight.is_vertical_unit_known;
  return json;
}

void warn_of(const TerrainSight& sight, const HorizontalMetric& metric, Session& session) {
  if (!metric.is_known) session.warn("the raster has no CRS: x and y are taken for metres");
  if (!sight.is_vertical_unit_known)
    session.warn(fmt::format(
        "the raster has no known unit of heights: they are taken {}; --height-unit says",
        metric.assumed_height_unit() == 1 ? "for metres" : "to be in the unit of x and y"));
  const bool is_sure = sight.terrain.is_everywhere || sight.terrain.max_error == 0 ||
                       sight.verdict == SightVerdict::undecided;
  if (!is_sure)
    session.warn(
        "the bounds of this terrain hold at its samples alone, as their heights are not at hand: "
        "between them it may be higher or lower; a raster in its place is held against all of its "
        "heights");
}

Result<Outcome> run_sight(const SightArguments& arguments, Session& session) {
  LODE_TRY(TerrainSightOptions options, to_sight_options(arguments));
  TerrainQueryArguments terrain = arguments.terrain;
  terrain.way = {options.from, options.to};
  terrain.way_crs = arguments.places_crs;
  LODE_TRY(const TerrainInput input, read_terrain(terrain, session));
  LODE_TRY(const auto source, open_places_crs(arguments.places_crs, arguments.terrain.input,
                                              input.opened.facts.frame, session));
  LODE_TRY(const TerrainWay way,
           way_on(input.opened, input.metric, source, {.from = options.from, .to = options.to}));
  options.from = way.from;
  options.to = way.to;
  LODE_CHECK(check_upwards(input.opened.facts.frame, arguments.terrain.input));
  LODE_TRY(const TerrainSight sight,
           naming(arguments.terrain.input,
                  find_terrain_sight(input.opened.terrain, input.options, input.metric, options,
                                     session.progress()),
                  session));
  warn_of(sight, input.metric, session);
  warn_of_long_way(input.metric, input.opened.facts.frame, options.from, options.to, session);
  Outcome outcome;
  Json& json = outcome.json;
  json["command"] = "sight";
  json["input"] = arguments.terrain.input;
  json["outputs"] = Json::array();
  Table table;
  add_facts(input.opened.facts, json, table);
  json["model"] = name_of(input.opened.model);
  add_metric(input.metric, json, input.target);
  json["places_crs"] = source ? Json(source->name) : Json(nullptr);
  json["observer_height"] = options.observer_height;
  json["target_height"] = options.target_height;
  json["refraction"] = options.refraction;
  json.update(sight_json(sight));
  json["seconds"] = {{"read", input.read_seconds}, {"sight", sight.seconds}};
  json["warnings"] = session.warnings();
  table.add({"model", name_of(input.opened.model)});
  table.add({"max error", fmt::format("{}, {} {}", format_number(sight.terrain.max_error),
                                      format_number(sight.terrain.achieved_error),
                                      bound_kind_of(sight.terrain))});
  table.add({"triangles", format_count(sight.terrain.triangles)});
  if (arguments.is_exact) table.add({"rounds", format_count(sight.n_rounds)});
  table.add({"distance", fmt::format("{} ({})", format_number(sight.distance),
                                     describe_metric(input.metric, input.target))});
  table.add({"earth", fmt::format("radius {} m, refraction {}", format_number(sight.radius),
                                  format_number(options.refraction))});
  table.add({"read", format_seconds(input.read_seconds)});
  table.add({"sight", format_seconds(sight.seconds)});
  table.add({verdict_name(sight.verdict), reason_of(sight) + limit_of(sight)});
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace

Command add_sight_command(CLI::App& program) {
  auto arguments = std::make_shared<SightArguments>();
  CLI::App* app =
      program.add_subcommand("sight", "Find out whether two places of a terrain see each other");
  app->footer(
      "visible: no surface within the bounds of the TIN is above the ray; blocked: each one is,\n"
      "and where; undecided: neither, and --exact asks again at full resolution, or at the finest\n"
      "level of a file that was built for less. Bounds are\n"
      "those of lode height --everywhere where all heights are at hand (rasters, quadtrees,\n"
      "quaternary triangulations, bisected right triangles), else at samples. Gaps on the way\n"
      "leave it undecided; where the surfaces of a model's squares or triangles do not meet, the\n"
      "bounds of both hold, and there is no gap. The ray is straight over an\n"
      "earth whose radius is R / (1 - refraction).\n\n"
      "Examples:\n  lode sight dem.tif --from 500000,4000000 --to 520000,4010000\n"
      "  lode sight dem.tif --from 8.1,46.5 --to 8.2,46.6 --target-height 30 --exact");
  arguments->terrain.may_be_everywhere = true;
  add_terrain_query(*app, arguments->terrain);
  add_distance_crs(*app, arguments->terrain);
  add_segment(*app, arguments->from, arguments->to);
  add_places_crs(*app, arguments->places_crs, "--from and --to");
  const auto add = [&](const char* name, std::string& value, const char* type, const char* help) {
    app->add_option(name, value, help)->type_name(type);
  };
  add("--observer-height", arguments->observer_height, "H",
      "Of the eye above the terrain at --from, in the unit of the heights (default: 1.8)");
  add("--target-height", arguments->target_height, "H",
      "Of what is looked at above the terrain at --to (default: 0)");
  add("--refraction", arguments->refraction, "K",
      "Bending of light as a share of the earth's curvature (default: 0.13; 1: a flat earth)");
  add("--height-unit", arguments->height_unit, "m|ft|us-ft",
      "Unit of the heights, where the raster does not say or is wrong");
  app->add_flag("--exact", arguments->is_exact,
                "Where it is undecided, ask again at full resolution, or a file's finest level");
  return {app, [arguments] { return check_sight(*arguments); },
          [arguments](Session& session) { return run_sight(*arguments, session); }};
}

}  // namespace lode::cli
