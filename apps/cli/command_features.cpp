#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "command.h"
#include "feature_output.h"
#include "parse.h"
#include "stopwatch.h"
#include "terrain_facts.h"
#include "terrain_query.h"
#include "to_crs.h"
#include "vector_output.h"

namespace lode::cli {
namespace {

struct FeatureArguments {
  TerrainQueryArguments terrain;
  std::string output;
  std::string relief;
};

Result<std::optional<double>> to_relief(const std::string& text) {
  if (text.empty()) return std::optional<double>();
  LODE_TRY(const double relief, parse_number("--feature-relief", text));
  if (!(relief >= 0)) return fail("--feature-relief: expected a number >= 0, got '{}'", text);
  return std::optional(relief);
}

Result<void> check_features(const FeatureArguments& arguments) {
  LODE_CHECK(check_terrain_query(arguments.terrain, ""));
  if (auto relief = to_relief(arguments.relief); !relief) return relief.error();
  LODE_CHECK(check_line_output(arguments.output));
  LODE_CHECK(check_to_crs_output(arguments.terrain.terrain, arguments.output));
  return check_paths_differ({arguments.terrain.input}, {arguments.output});
}

std::int64_t alternating_sum(const terrain_features::FeatureCounts& counts) {
  return static_cast<std::int64_t>(counts.peaks - counts.passes + counts.pits);
}

/// What was found, and that it adds up.
void add_found(const TerrainFeatures& features, bool is_default, Json& json, Table& table) {
  const terrain_features::FeatureCounts& kept = features.kept;
  const terrain_features::FeatureCounts& all = features.all;
  const auto add_counts = [&](const char* name, std::uint64_t n_kept, std::uint64_t n_all) {
    json["kept"][name] = n_kept;
    json["all"][name] = n_all;
    table.add({name, fmt::format("{} of {}", format_count(n_kept), format_count(n_all))});
  };
  json["relief"] = features.least_relief;
  json["relief_is_default"] = is_default;
  table.add({"least relief", fmt::format("{} ({})", format_number(features.least_relief),
                                         is_default ? "default: 1 % of the range" : "as asked")});
  add_counts("peaks", kept.peaks, all.peaks);
  add_counts("passes", kept.passes, all.passes);
  add_counts("pits", kept.pits, all.pits);
  json["euler_number"] = features.euler_number;
  json["triangles"] = features.n_triangles;
  table.add({"Euler number",
             fmt::format("{} of the surface; peaks - passes + pits: {} of all, {} of those kept",
                         features.euler_number, alternating_sum(all), alternating_sum(kept))});
  json["ridges"] = features.n_ridges;
  json["channels"] = features.n_channels;
  json["points"] = features.n_line_points;
  table.add({"lines", fmt::format("{} of ridges, {} of channels", format_count(features.n_ridges),
                                  format_count(features.n_channels))});
  table.add({"their points", format_count(features.n_line_points)});
}

void add_feature_output(const FeatureArguments& arguments, const TerrainFeatures& features,
                        double read_seconds, double write_seconds, Json& json, Table& table) {
  std::error_code unknown;
  const std::uintmax_t n_bytes = std::filesystem::file_size(arguments.output, unknown);
  json["bytes"] = unknown ? Json(nullptr) : Json(n_bytes);
  json["seconds"] = {{"read", read_seconds},
                     {"select", features.select_seconds},
                     {"find", features.find_seconds},
                     {"write", write_seconds}};
  table.add({"read", format_seconds(read_seconds)});
  table.add({"find", format_seconds(features.select_seconds + features.find_seconds)});
  table.add({"write", format_seconds(write_seconds)});
  table.add({"output",
             fmt::format("{}{}", arguments.output, unknown ? "" : ", " + format_bytes(n_bytes))});
}

/// Points and lines to the CRS of --to-crs; heights stay.
Result<void> map_features(const std::string& input, const std::optional<TargetCrs>& target,
                          TerrainFeatures& features, Session& session, Json& json, Table& table) {
  std::vector<std::span<Vec3d>> all;
  for (TerrainFeatures::Point& point : features.points) all.emplace_back(&point.at, 1);
  for (TerrainFeatures::Line& line : features.lines) all.emplace_back(line.points);
  std::vector<std::vector<Place>> places(all.size());
  std::vector<std::span<Place>> lines(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const Vec3d& p : all[i]) places[i].push_back({{p[0], p[1]}});
    lines[i] = places[i];
  }
  LODE_CHECK(map_to_crs(input, target, lines, session, json, table));
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = 0; k < all[i].size(); ++k)
      all[i][k] = {{places[i][k][0], places[i][k][1], all[i][k][2]}};
  return {};
}

Result<Outcome> run_features(const FeatureArguments& arguments, Session& session) {
  const std::string& input = arguments.terrain.input;
  LODE_TRY(const auto relief, to_relief(arguments.relief));
  LODE_CHECK(check_writable(arguments.output));
  LODE_TRY(const TerrainInput terrain, read_terrain(arguments.terrain, session));
  const TerrainFacts& facts = terrain.opened.facts;
  LODE_CHECK(check_known_crs(arguments.output, input, facts));
  LODE_CHECK(check_upwards(facts.frame, input));
  LODE_TRY(TerrainFeatures features,
           naming(input, find_terrain_features(terrain.opened.terrain, relief, session.progress()),
                  session));
  if (features.lines.empty())
    session.warn(fmt::format("there are no ridges and channels: no pass has a relief of {} or more",
                             format_number(features.least_relief)));
  const Stopwatch watch;
  Outcome outcome;
  Json& json = outcome.json;
  Table table;
  json["command"] = "features";
  json["input"] = input;
  json["outputs"] = Json::array({arguments.output});
  add_facts(facts, json, table);
  LODE_CHECK(map_features(input, terrain.target, features, session, json, table));
  LODE_CHECK(write_features(arguments.output, terrain, features, session.progress()));
  const double write_seconds = watch.seconds();
  add_found(features, !relief, json, table);
  add_feature_output(arguments, features, terrain.read_seconds, write_seconds, json, table);
  json["warnings"] = session.warnings();
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace

Command add_features_command(CLI::App& program) {
  auto arguments = std::make_shared<FeatureArguments>();
  CLI::App* app =
      program.add_subcommand("features", "Write peaks, passes, pits, ridges and channels");
  app->footer(
      "Peaks, passes and pits of the surface through all samples, and from each pass the ridges\n"
      "up and the channels down, along its edges; what ridges or channels share is written once.\n"
      "Kept is what rises or falls by at least --feature-relief to where it is paired by\n"
      "persistence: of a peak its prominence, of a pit the depth of its lake.\n\n"
      "OUT may end in .gpkg (GeoPackage, in the raster's CRS or --to-crs: layers critical_points,\n"
      "ridges, channels), .geojson (RFC 7946: one collection, told apart by `kind`) or .vtp (in "
      "space).\n\n"
      "Examples:\n  lode features dem.tif features.gpkg --feature-relief 50\n"
      "  lode features dem.tif all.vtp --feature-relief 0\n"
      "  lode features survey.las ridges.geojson --class 2");
  add_terrain_source(*app, arguments->terrain, TerrainUse::reading);
  add_to_crs(*app, arguments->terrain.terrain,
             "Write coordinates in this CRS, through PROJ: vertices of lines, with straight pieces "
             "between them; of .gpkg and .vtp");
  app->add_option("output", arguments->output, "File to write")->type_name("OUT")->required();
  app->add_option("--feature-relief", arguments->relief,
                  "Least relief, in units of the heights (default: 1 % of their range; 0: all)")
      ->type_name("R");
  return {app, [arguments] { return check_features(*arguments); },
          [arguments](Session& session) { return run_features(*arguments, session); }};
}

}  // namespace lode::cli
