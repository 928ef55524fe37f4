#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "asked_places.h"
#include "command.h"
#include "lode/api/terrain_neighbours.h"
#include "neighbour_output.h"
#include "outputs.h"
#include "parse.h"
#include "places_crs.h"
#include "stopwatch.h"
#include "terrain_query.h"
#include "vector_output.h"

namespace lode::cli {
namespace {

constexpr std::int64_t kMostRings = 1'000'000'000;

struct NeighbourArguments {
  TerrainQueryArguments terrain;
  AskedPlaces places;
  std::string rings;
  std::string output;
};

Result<std::uint32_t> parse_rings(const std::string& text) {
  if (text.empty()) return 1U;
  LODE_TRY(const auto n, parse_integer("--rings", text, 0, kMostRings));
  return static_cast<std::uint32_t>(n);
}

Result<void> check_neighbours(const NeighbourArguments& arguments) {
  LODE_CHECK(check_terrain_query(arguments.terrain, ""));
  LODE_CHECK(check_asked_places(arguments.places, arguments.terrain.input));
  if (auto rings = parse_rings(arguments.rings); !rings) return rings.error();
  if (arguments.output.empty()) return {};
  if (!check_extension(arguments.output, ".csv") && !check_vector_path(arguments.output))
    return fail("{}: expected an output that ends in .csv, .gpkg or .geojson", arguments.output);
  return check_paths_differ(asked_inputs(arguments.places, arguments.terrain.input),
                            {arguments.output});
}

struct NeighbourAnswer {
  const NeighbourArguments& arguments;
  const TerrainAnswerer& answerer;
  const std::vector<Place>& places;  ///< As they are given.
  const std::optional<SourceCrs>& source;
  std::uint32_t n_rings;
  const std::vector<TerrainNeighbours>& answers;
  const NeighboursReport& report;
};

std::string neighbour_table(const NeighbourAnswer& answer) {
  Table table({"place", "ring", "triangle", "corner 1", "corner 2", "corner 3", "bound", "beside 1",
               "beside 2", "beside 3"});
  const HeightRange range = answer.answerer.opened.terrain.range();
  const auto corner = [&](const Vec3d& p) {
    return fmt::format("{:.12g}, {:.12g}, {}", p[0], p[1],
                       format_height(p[2], range.upper - range.lower));
  };
  for (std::size_t i = 0; i < answer.answers.size(); ++i) {
    const TerrainNeighbours& one = answer.answers[i];
    if (one.triangles.empty())
      table.add({fmt::format("{}", i + 1), status_name(one.where), "", "", "", "", "", "", "", ""});
    for (const TerrainTriangle& t : one.triangles) {
      const auto beside = describe_beside(t);
      table.add({fmt::format("{}", i + 1), fmt::format("{}", t.ring), fmt::format("{}", t.triangle),
                 corner(t.corners[0]), corner(t.corners[1]), corner(t.corners[2]),
                 format_number(t.bound), beside[0], beside[1], beside[2]});
    }
  }
  return table.to_string();
}

Json triangle_json(const TerrainTriangle& triangle) {
  Json json;
  json["triangle"] = triangle.triangle;
  json["ring"] = triangle.ring;
  Json& corners = json["corners"] = Json::array();
  for (const Vec3d& p : triangle.corners) corners.push_back({p[0], p[1], p[2]});
  json["bound"] = triangle.bound;
  Json& beside = json["beside"] = Json::array({Json::array(), Json::array(), Json::array()});
  for (const TerrainTriangle::Beside& one : triangle.beside)
    beside[one.edge].push_back({{"triangle", one.triangle}, {"edge", one.other_edge + 1}});
  return json;
}

Json points_json(const NeighbourAnswer& answer) {
  Json points = Json::array();
  for (std::size_t i = 0; i < answer.places.size(); ++i) {
    Json one;
    one["x"] = answer.places[i][0];
    one["y"] = answer.places[i][1];
    one["status"] = status_name(answer.answers[i].where);
    Json& triangles = one["triangles"] = Json::array();
    for (const TerrainTriangle& triangle : answer.answers[i].triangles)
      triangles.push_back(triangle_json(triangle));
    points.push_back(std::move(one));
  }
  return points;
}

Outcome outcome_of(const NeighbourAnswer& answer, Session& session) {
  const NeighbourArguments& arguments = answer.arguments;
  Outcome outcome;
  Json& json = outcome.json;
  json["command"] = "neighbours";
  json["input"] = arguments.terrain.input;
  json["outputs"] = arguments.output.empty() ? Json::array() : Json::array({arguments.output});
  Table table;
  add_terrain_head(answer.answerer, arguments.terrain, json, table);
  json["bound_kind"] = bound_kind_of(answer.answerer.tin.report());
  json["places_crs"] = answer.source ? Json(answer.source->name) : Json(nullptr);
  json["rings"] = answer.n_rings;
  json["places"] = answer.places.size();
  json["outside"] = answer.report.n_outside;
  json["in_gaps"] = answer.report.n_in_gaps;
  json["answered_triangles"] = answer.report.n_triangles;
  // To files they may be millions.
  if (arguments.output.empty()) json["points"] = points_json(answer);
  json["seconds"] = {{"read", answer.answerer.read_seconds},
                     {"select", answer.answerer.tin.report().seconds},
                     {"prepare", answer.report.prepare_seconds},
                     {"find", answer.report.seconds}};
  json["warnings"] = session.warnings();
  table.add({"places", format_count(answer.places.size()) +
                           (answer.source ? ", in " + answer.source->name : "")});
  table.add({"outside", format_count(answer.report.n_outside)});
  table.add({"in gaps", format_count(answer.report.n_in_gaps)});
  table.add({"rings", format_count(answer.n_rings)});
  table.add({"found", format_count(answer.report.n_triangles) + " triangles"});
  table.add({"prepare", format_seconds(answer.report.prepare_seconds)});
  table.add({"find", format_seconds(answer.report.seconds)});
  if (!arguments.output.empty()) table.add({"output", arguments.output});
  outcome.text = table.to_string();
  if (arguments.output.empty()) outcome.text += '\n' + neighbour_table(answer);
  return outcome;
}

Result<Outcome> run_neighbours(const NeighbourArguments& arguments, Session& session) {
  LODE_TRY(const std::uint32_t n_rings, parse_rings(arguments.rings));
  if (!arguments.output.empty()) LODE_CHECK(check_writable(arguments.output));
  LODE_TRY(const std::vector<Place> places, read_asked_places(arguments.places));
  const auto accept = [&](const TerrainFacts& facts) {
    return check_known_crs(arguments.output, arguments.terrain.input, facts);
  };
  LODE_TRY(const TerrainAnswerer answerer,
           answer_terrain(arguments.terrain, session, accept, TinUse::triangles));
  LODE_TRY(const auto source, open_places_crs(arguments.places.crs, arguments.terrain.input,
                                              answerer.opened.facts.frame, session));
  LODE_TRY(const std::vector<Place> asked, places_of_terrain(places, source));
  std::vector<TerrainNeighbours> answers;
  LODE_TRY(const NeighboursReport report,
           naming(arguments.terrain.input,
                  answerer.tin.neighbours(asked, {.n_rings = n_rings, .threads = session.threads()},
                                          answers, session.progress()),
                  session));
  const NeighbourAnswer answer{arguments, answerer, places, source, n_rings, answers, report};
  const std::uint64_t n_off = report.n_outside + report.n_in_gaps;
  if (n_off > 0)
    session.warn(fmt::format("{} of {} places lie in no triangle: {} outside, {} in gaps", n_off,
                             places.size(), report.n_outside, report.n_in_gaps));
  if (!arguments.output.empty())
    LODE_CHECK(write_neighbours(arguments.output, answerer, places, answers, session.progress()));
  return outcome_of(answer, session);
}

}  // namespace

Command add_neighbours_command(CLI::App& program) {
  auto arguments = std::make_shared<NeighbourArguments>();
  arguments->terrain.is_closed = true;
  CLI::App* app = program.add_subcommand(
      "neighbours", "Show the triangles of a terrain at places, and those beside them");
  app->footer(
      "Of the TIN within --max-error, ring 0 are the triangles that hold the place: one, or at an\n"
      "edge or a corner all that do. Ring 1 are those across their edges, and so on up to "
      "--rings.\n"
      "Each comes with its corners (x, y, height; turning left), its bound (as of lode height)\n"
      "and with what lies beside its edges 1 to 3, from corner 1 to 2, 2 to 3 and 3 to 1: 7:2 is\n"
      "edge 2 of triangle 7, and none says that the domain ends there. Of surface quadtrees and\n"
      "quaternary triangulations, whose squares and triangles differ in size, several lie beside\n"
      "one edge: all that have a part of it, in order. Triangles are numbered from 0 in the whole\n"
      "TIN, so that places' answers fit together. On a raster that goes round the earth those of\n"
      "its first and last column are neighbours.\n"
      "OUT has a row, or polygon in the raster's CRS (.gpkg) or in longitudes and latitudes\n"
      "(.geojson), for each triangle of each place.\n\n"
      "Examples:\n  lode neighbours dem.tif --at 500010,4000020 --max-error 1\n"
      "  lode neighbours dem.lode stations.csv --max-error 5 --rings 3 --out near.gpkg\n"
      "  lode neighbours utm.tif gps.csv --places-crs EPSG:4326 --out near.csv");
  add_terrain_query(*app, arguments->terrain);
  add_everywhere(*app, arguments->terrain);
  add_asked_places(*app, arguments->places);
  app->add_option("--rings", arguments->rings,
                  "So many steps across edges from the triangles at the place (default: 1)")
      ->type_name("N");
  app->add_option("-o,--output,--out", arguments->output,
                  "Write triangles to .csv, .gpkg or .geojson")
      ->type_name("OUT");
  return {app, [arguments] { return check_neighbours(*arguments); },
          [arguments](Session& session) { return run_neighbours(*arguments, session); }};
}

}  // namespace lode::cli
