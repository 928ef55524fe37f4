#include <fmt/format.h>

#include <memory>
#include <span>
#include <vector>

#include "command.h"
#include "contour_levels.h"
#include "contour_output.h"
#include "outputs.h"
#include "stopwatch.h"
#include "terrain_input.h"
#include "terrain_query.h"
#include "to_crs.h"
#include "vector_output.h"

namespace lode::cli {
namespace {

struct ContourArguments {
  TerrainQueryArguments terrain;
  std::string output;
  LevelArguments levels;
  bool is_polygons = false;
};

Result<void> check_contours(const ContourArguments& arguments) {
  LODE_CHECK(check_terrain_query(arguments.terrain,
                                 "isosurfaces of volumes and meshes, and contour lines of images, "
                                 "are made by lode extract --isovalue"));
  if (auto levels = to_levels(arguments.levels); !levels) return levels.error();
  if (auto status = check_line_output(arguments.output);
      arguments.is_polygons && (!status || is_vtp_path(arguments.output)))
    return fail(
        "--polygons: expected an output that ends in .gpkg or .geojson (.vtp takes lines alone), "
        "got {}",
        arguments.output);
  LODE_CHECK(check_line_output(arguments.output));
  LODE_CHECK(check_to_crs_output(arguments.terrain.terrain, arguments.output));
  return check_paths_differ({arguments.terrain.input}, {arguments.output});
}

struct ContourAnswer {
  const ContourArguments& arguments;
  const TerrainAnswerer& answerer;
  const std::vector<double>& levels;
};

void add_head(const ContourAnswer& answer, Json& json, Table& table) {
  json["command"] = "contours";
  json["input"] = answer.arguments.terrain.input;
  json["outputs"] = Json::array({answer.arguments.output});
  add_terrain_head(answer.answerer, answer.arguments.terrain, json, table);
  json["levels"] = answer.levels.size();
  const HeightRange range = answer.answerer.tin.height_range();
  const double relief = range.upper - range.lower;
  table.add({"contours", answer.levels.empty()
                             ? std::string("none")
                             : fmt::format("{} from {} to {}", format_count(answer.levels.size()),
                                           format_height(answer.levels.front(), relief),
                                           format_height(answer.levels.back(), relief))});
}

/// To the CRS of --to-crs.
Result<void> map_lines_of(const ContourAnswer& answer, std::vector<std::span<Place>>& lines,
                          Session& session, Json& json, Table& table) {
  return map_to_crs(answer.arguments.terrain.input, answer.answerer.target, lines, session, json,
                    table);
}

void add_times(const ContourAnswer& answer, double trace, double write, Json& json, Table& table) {
  json["seconds"] = {{"read", answer.answerer.read_seconds},
                     {"select", answer.answerer.tin.report().seconds},
                     {"trace", trace},
                     {"write", write}};
  table.add({"trace", format_seconds(trace)});
  table.add({"write", format_seconds(write)});
  table.add({"output", answer.arguments.output});
}

Result<Outcome> run_lines(const ContourAnswer& answer, Session& session) {
  LODE_TRY(TerrainContours contours,
           answer.answerer.tin.contours(answer.levels, session.progress()));
  const HeightRange range = answer.answerer.tin.height_range();
  if (contours.lines.empty())
    session.warn(fmt::format("there are no contours: heights are from {}",
                             format_heights(range.lower, range.upper)));
  const Stopwatch watch;
  Outcome outcome;
  Json& json = outcome.json;
  Table table;
  add_head(answer, json, table);
  std::vector<std::span<Place>> lines;
  for (TerrainContours::Line& line : contours.lines) lines.emplace_back(line.points);
  LODE_CHECK(map_lines_of(answer, lines, session, json, table));
  LODE_CHECK(
      write_contours(answer.arguments.output, answer.answerer, contours, session.progress()));
  const double write_seconds = watch.seconds();
  json["lines"] = contours.lines.size();
  json["rings"] = contours.n_rings;
  json["points"] = contours.n_points;
  json["left_out"] = contours.n_left_out;
  json["uphill"] = "left";
  table.add(
      {"lines", fmt::format("{}, {} of them rings, higher ground on their left",
                            format_count(contours.lines.size()), format_count(contours.n_rings))});
  table.add({"points", format_count(contours.n_points)});
  if (contours.n_left_out > 0)
    table.add({"left out",
               fmt::format("{} summits of just such a height", format_count(contours.n_left_out))});
  add_times(answer, contours.seconds, write_seconds, json, table);
  json["warnings"] = session.warnings();
  outcome.text = table.to_string();
  return outcome;
}

Result<Outcome> run_polygons(const ContourAnswer& answer, Session& session) {
  LODE_TRY(TerrainBands bands, answer.answerer.tin.bands(answer.levels, session.progress()));
  const Stopwatch watch;
  Outcome outcome;
  Json& json = outcome.json;
  Table table;
  add_head(answer, json, table);
  std::vector<std::span<Place>> rings;
  for (TerrainBands::Polygon& polygon : bands.polygons)
    for (std::vector<Place>& ring : polygon.rings) rings.emplace_back(ring);
  LODE_CHECK(map_lines_of(answer, rings, session, json, table));
  LODE_CHECK(write_bands(answer.arguments.output, answer.answerer, bands, session.progress()));
  const double write_seconds = watch.seconds();
  json["polygons"] = bands.polygons.size();
  json["holes"] = bands.n_holes;
  json["points"] = bands.n_points;
  table.add({"polygons", fmt::format("{}, with {} holes", format_count(bands.polygons.size()),
                                     format_count(bands.n_holes))});
  table.add({"points", format_count(bands.n_points)});
  add_times(answer, bands.seconds, write_seconds, json, table);
  json["warnings"] = session.warnings();
  outcome.text = table.to_string();
  return outcome;
}

Result<Outcome> run_contours(const ContourArguments& arguments, Session& session) {
  LODE_TRY(const ContourLevels wanted, to_levels(arguments.levels));
  LODE_CHECK(check_writable(arguments.output));
  const auto accept = [&](const TerrainFacts& facts) {
    return check_known_crs(arguments.output, arguments.terrain.input, facts);
  };
  const TinUse use = arguments.is_polygons ? TinUse::all : TinUse::lines;
  LODE_TRY(const TerrainAnswerer answerer, answer_terrain(arguments.terrain, session, accept, use));
  if (!answerer.target) hint_at_wrap(answerer.opened, arguments.terrain.input, session);
  const HeightRange range = answerer.tin.height_range();
  LODE_TRY(const std::vector<double> levels, wanted.within(range.lower, range.upper));
  const ContourAnswer answer{arguments, answerer, levels};
  return arguments.is_polygons ? run_polygons(answer, session) : run_lines(answer, session);
}

}  // namespace

Command add_contours_command(CLI::App& program) {
  auto arguments = std::make_shared<ContourArguments>();
  CLI::App* app = program.add_subcommand("contours", "Trace contour lines of a terrain");
  app->footer(
      "Lines are those of the TIN within --max-error, joined, rings closed, with higher ground on\n"
      "their left. A vertex at just the height of a contour counts as above it.\n\n"
      "--polygons fills the bands between them instead, and what is below and above all.\n\n"
      "OUT may end in .gpkg (GeoPackage, in the raster's CRS or --to-crs), .geojson (RFC 7946:\n"
      "longitudes and latitudes of WGS 84, to which it is transformed) or .vtp (in space).\n\n"
      "Examples:\n  lode contours dem.tif contours.gpkg --interval 100 --max-error 5\n"
      "  lode contours dem.tif shore.geojson --isovalue 0 --max-error 1\n"
      "  lode contours dem.tif bands.gpkg --interval 100 --polygons");
  add_terrain_query(*app, arguments->terrain);
  add_to_crs(*app, arguments->terrain.terrain,
             "Write coordinates in this CRS, through PROJ: vertices of lines and polygons, with "
             "straight pieces between them; of .gpkg and .vtp");
  app->add_option("output", arguments->output, "File to write")->type_name("OUT")->required();
  add_level_options(*app, arguments->levels);
  app->add_flag("--polygons", arguments->is_polygons,
                "Write the bands between contours, with `lower` and `upper`");
  return {app, [arguments] { return check_contours(*arguments); },
          [arguments](Session& session) { return run_contours(*arguments, session); }};
}

}  // namespace lode::cli
