#include <fmt/format.h>

#include <iterator>
#include <memory>

#include "command.h"
#include "outputs.h"
#include "places_crs.h"
#include "terrain_query.h"

namespace lode::cli {
namespace {

struct ProfileArguments {
  TerrainQueryArguments terrain;
  std::string from;
  std::string to;
  std::string places_crs;
  std::string output;
};

Result<void> check_profile(const ProfileArguments& arguments) {
  LODE_CHECK(check_terrain_query(arguments.terrain,
                                 "profiles of meshes of cells are made by lode probe --line"));
  LODE_CHECK(check_segment(arguments.from, arguments.to));
  LODE_CHECK(check_places_crs(arguments.places_crs));
  if (arguments.output.empty()) return {};
  LODE_CHECK(check_extension(arguments.output, ".csv"));
  return check_paths_differ({arguments.terrain.input}, {arguments.output});
}

std::string profile_csv(const TerrainProfile& profile) {
  std::string text = "part,distance,x,y,height,bound\n";
  auto out = std::back_inserter(text);
  for (const TerrainProfile::Point& point : profile.points)
    fmt::format_to(out, "{},{},{},{},{},{}\n", point.part, point.distance, point.at[0], point.at[1],
                   point.height, point.bound);
  return text;
}

std::string profile_table(const TerrainProfile& profile, const HeightRange& range) {
  Table table({"part", "distance", "x", "y", "height", "bound"});
  for (const TerrainProfile::Point& point : profile.points)
    table.add({fmt::format("{}", point.part), format_number(point.distance),
               fmt::format("{:.12g}", point.at[0]), fmt::format("{:.12g}", point.at[1]),
               format_height(point.height, range.upper - range.lower), format_number(point.bound)});
  return table.to_string();
}

Json points_json(const TerrainProfile& profile) {
  Json points = Json::array();
  for (const TerrainProfile::Point& point : profile.points)
    points.push_back({{"part", point.part},
                      {"distance", point.distance},
                      {"x", point.at[0]},
                      {"y", point.at[1]},
                      {"height", point.height},
                      {"bound", point.bound}});
  return points;
}

/// From its lowest to its highest point.
std::string describe_range(const TerrainProfile& profile) {
  if (profile.points.empty()) return "none";
  const auto [lowest, highest] =
      std::ranges::minmax(profile.points, {}, &TerrainProfile::Point::height);
  return format_heights(lowest.height, highest.height);
}

Outcome outcome_of(const ProfileArguments& arguments, const TerrainAnswerer& answerer,
                   const TerrainProfile& profile, Session& session) {
  Outcome outcome;
  Json& json = outcome.json;
  json["command"] = "profile";
  json["input"] = arguments.terrain.input;
  json["outputs"] = arguments.output.empty() ? Json::array() : Json::array({arguments.output});
  Table table;
  add_terrain_head(answerer, arguments.terrain, json, table);
  json["bound_kind"] = bound_kind_of(answerer.tin.report());
  add_metric(answerer.metric, json, answerer.target);
  json["length"] = profile.length;
  json["parts"] = profile.points.empty() ? 0 : profile.points.back().part;
  json["profile_rows"] = profile.points.size();
  Json& gaps = json["gaps"] = Json::array();
  double gap_length = 0;
  for (const TerrainProfile::Gap& gap : profile.gaps) {
    gaps.push_back({{"begin", gap.begin}, {"end", gap.end}});
    gap_length += gap.end - gap.begin;
  }
  json["steps"] = profile.n_steps;
  json["largest_step"] = profile.largest_step;
  if (arguments.output.empty()) json["points"] = points_json(profile);
  json["seconds"] = {{"read", answerer.read_seconds},
                     {"select", answerer.tin.report().seconds},
                     {"profile", profile.seconds}};
  json["warnings"] = session.warnings();
  table.add({"distance", describe_metric(answerer.metric, answerer.target)});
  table.add({"length", format_number(profile.length)});
  table.add({"gaps", profile.gaps.empty()
                         ? std::string("none")
                         : fmt::format("{}, {} long together", format_count(profile.gaps.size()),
                                       format_number(gap_length))});
  if (profile.n_steps > 0)
    table.add({"steps", fmt::format("{}, up to {}", format_count(profile.n_steps),
                                    format_number(profile.largest_step))});
  table.add({"heights", describe_range(profile)});
  table.add({"rows", format_count(profile.points.size())});
  table.add({"profile", format_seconds(profile.seconds)});
  if (!arguments.output.empty()) table.add({"output", arguments.output});
  outcome.text = table.to_string();
  if (arguments.output.empty() && !profile.points.empty())
    outcome.text += '\n' + profile_table(profile, answerer.opened.terrain.range());
  return outcome;
}

Result<Outcome> run_profile(const ProfileArguments& arguments, Session& session) {
  LODE_TRY(const Place from, parse_place("--from", arguments.from));
  LODE_TRY(const Place to, parse_place("--to", arguments.to));
  if (!arguments.output.empty()) LODE_CHECK(check_writable(arguments.output));
  TerrainQueryArguments terrain = arguments.terrain;
  terrain.way = {from, to};
  terrain.way_crs = arguments.places_crs;
  LODE_TRY(const TerrainAnswerer answerer, answer_terrain(terrain, session, {}, TinUse::places));
  LODE_TRY(const auto source, open_places_crs(arguments.places_crs, arguments.terrain.input,
                                              answerer.opened.facts.frame, session));
  LODE_TRY(const TerrainWay way,
           way_on(answerer.opened, answerer.metric, source, {.from = from, .to = to}));
  LODE_TRY(const TerrainProfile profile,
           naming(arguments.terrain.input,
                  answerer.tin.profile(way.from, way.to, session.progress()), session));
  warn_of_long_way(answerer.metric, answerer.opened.facts.frame, way.from, way.to, session);
  if (profile.points.empty()) session.warn("the segment meets no terrain");
  if (!arguments.output.empty())
    LODE_CHECK(write_text(arguments.output, profile_csv(profile), session.progress()));
  Outcome outcome = outcome_of(arguments, answerer, profile, session);
  outcome.json["places_crs"] = source ? Json(source->name) : Json(nullptr);
  return outcome;
}

}  // namespace

Command add_profile_command(CLI::App& program) {
  auto arguments = std::make_shared<ProfileArguments>();
  CLI::App* app = program.add_subcommand(
      "profile", "Show the heights of a terrain along a segment, with their bounds");
  app->footer(
      "A row for each edge or vertex of the TIN within --max-error that the segment meets, and\n"
      "for its ends: in between heights are linear. Between parts there is no terrain. The\n"
      "segment is straight in the raster's coordinates, which rows have; distances along it are "
      "in\n"
      "the plane of a projected CRS, and on the ellipsoid where coordinates are longitudes and\n"
      "latitudes, or those of --to-crs. `bound` holds at samples: none in the triangles beside is\n"
      "farther from them. Of surface quadtrees and quaternary triangulations rows are at sides of\n"
      "squares and triangles, and two at one distance where their surfaces do not meet; what "
      "bends\n"
      "is cut, and bounds hold of straight lines between rows.\n\n"
      "Examples:\n  lode profile dem.tif --from 500000,4000000 --to 520000,4010000 --max-error 1\n"
      "  lode profile dem.tif --from 8.1,46.5 --to 8.2,46.6 --out profile.csv\n"
      "  lode profile dem.tif --from 8.1,46.5 --to 8.2,46.6 --to-crs EPSG:32632\n"
      "  lode profile utm.tif --from 8.1,46.5 --to 8.2,46.6 --places-crs EPSG:4326");
  add_terrain_query(*app, arguments->terrain);
  add_distance_crs(*app, arguments->terrain);
  add_everywhere(*app, arguments->terrain);
  add_segment(*app, arguments->from, arguments->to);
  add_places_crs(*app, arguments->places_crs, "--from and --to");
  app->add_option("-o,--output,--out", arguments->output, "Write part,distance,x,y,height,bound")
      ->type_name("OUT.csv");
  return {app, [arguments] { return check_profile(*arguments); },
          [arguments](Session& session) { return run_profile(*arguments, session); }};
}

}  // namespace lode::cli
