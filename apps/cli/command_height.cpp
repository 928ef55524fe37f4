#include <fmt/format.h>

#include <iterator>
#include <memory>
#include <optional>

#include "asked_places.h"
#include "command.h"
#include "outputs.h"
#include "places_crs.h"
#include "stopwatch.h"
#include "terrain_query.h"

namespace lode::cli {
namespace {

struct HeightArguments {
  TerrainQueryArguments terrain;
  AskedPlaces places;
  std::string output;
};

Result<void> check_height(const HeightArguments& arguments) {
  LODE_CHECK(check_terrain_query(arguments.terrain,
                                 "values in meshes of cells are found by lode probe --points"));
  LODE_CHECK(check_asked_places(arguments.places, arguments.terrain.input));
  if (arguments.output.empty()) return {};
  LODE_CHECK(check_extension(arguments.output, ".csv"));
  return check_paths_differ(asked_inputs(arguments.places, arguments.terrain.input),
                            {arguments.output});
}

struct HeightAnswer {
  const HeightArguments& arguments;
  const TerrainAnswerer& answerer;
  const std::vector<Place>& places;  ///< As they are given.
  const std::optional<SourceCrs>& source;
  const std::vector<TerrainHeight>& heights;
  const HeightsReport& report;

  [[nodiscard]] const char* bound_kind() const { return bound_kind_of(answerer.tin.report()); }
};

std::string height_csv(const HeightAnswer& answer) {
  std::string text = "x,y,height,bound,bound_kind\n";
  auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < answer.places.size(); ++i) {
    const Place& at = answer.places[i];
    const TerrainHeight& z = answer.heights[i];
    if (z.where == TerrainHeight::Where::inside)
      fmt::format_to(out, "{},{},{},{},{}\n", at[0], at[1], z.height, z.bound, answer.bound_kind());
    else
      fmt::format_to(out, "{},{},,,\n", at[0], at[1]);
  }
  return text;
}

std::string height_table(const HeightAnswer& answer) {
  Table table({"x", "y", "height", "bound", "bound kind"});
  const HeightRange range = answer.answerer.opened.terrain.range();
  for (std::size_t i = 0; i < answer.places.size(); ++i) {
    const Place& at = answer.places[i];
    const TerrainHeight& z = answer.heights[i];
    const bool is_inside = z.where == TerrainHeight::Where::inside;
    table.add({fmt::format("{:.12g}", at[0]), fmt::format("{:.12g}", at[1]),
               is_inside ? format_height(z.height, range.upper - range.lower) : "",
               is_inside ? format_number(z.bound) : "",
               is_inside ? answer.bound_kind() : status_name(z.where)});
  }
  return table.to_string();
}

Json points_json(const HeightAnswer& answer) {
  Json points = Json::array();
  for (std::size_t i = 0; i < answer.places.size(); ++i) {
    const TerrainHeight& z = answer.heights[i];
    Json one;
    one["x"] = answer.places[i][0];
    one["y"] = answer.places[i][1];
    one["status"] = status_name(z.where);
    const bool is_inside = z.where == TerrainHeight::Where::inside;
    one["height"] = is_inside ? Json(z.height) : Json(nullptr);
    one["bound"] = is_inside ? Json(z.bound) : Json(nullptr);
    points.push_back(std::move(one));
  }
  return points;
}

Outcome outcome_of(const HeightAnswer& answer, Session& session) {
  const HeightArguments& arguments = answer.arguments;
  Outcome outcome;
  Json& json = outcome.json;
  json["command"] = "height";
  json["input"] = arguments.terrain.input;
  json["outputs"] = arguments.output.empty() ? Json::array() : Json::array({arguments.output});
  Table table;
  add_terrain_head(answer.answerer, arguments.terrain, json, table);
  json["bound_kind"] = answer.bound_kind();
  json["places_crs"] = answer.source ? Json(answer.source->name) : Json(nullptr);
  json["places"] = answer.places.size();
  json["outside"] = answer.report.n_outside;
  json["in_gaps"] = answer.report.n_in_gaps;
  // To files they may be millions.
  if (arguments.output.empty()) json["points"] = points_json(answer);
  json["seconds"] = {{"read", answer.answerer.read_seconds},
                     {"select", answer.answerer.tin.report().seconds},
                     {"prepare", answer.report.prepare_seconds},
                     {"locate", answer.report.seconds}};
  json["warnings"] = session.warnings();
  table.add({"places", format_count(answer.places.size()) +
                           (answer.source ? ", in " + answer.source->name : "")});
  table.add({"outside", format_count(answer.report.n_outside)});
  table.add({"in gaps", format_count(answer.report.n_in_gaps)});
  table.add({"prepare", format_seconds(answer.report.prepare_seconds)});
  table.add({"locate", format_seconds(answer.report.seconds)});
  if (!arguments.output.empty()) table.add({"output", arguments.output});
  outcome.text = table.to_string();
  if (arguments.output.empty()) outcome.text += '\n' + height_table(answer);
  return outcome;
}

Result<Outcome> run_height(const HeightArguments& arguments, Session& session) {
  if (!arguments.output.empty()) LODE_CHECK(check_writable(arguments.output));
  LODE_TRY(const std::vector<Place> places, read_asked_places(arguments.places));
  LODE_TRY(const TerrainAnswerer answerer,
           answer_terrain(arguments.terrain, session, {}, TinUse::places));
  LODE_TRY(const auto source, open_places_crs(arguments.places.crs, arguments.terrain.input,
                                              answerer.opened.facts.frame, session));
  LODE_TRY(const std::vector<Place> asked, places_of_terrain(places, source));
  std::vector<TerrainHeight> heights;
  LODE_TRY(const HeightsReport report,
           answerer.tin.heights(asked, heights, session.threads(), session.progress()));
  const HeightAnswer answer{arguments, answerer, places, source, heights, report};
  const std::uint64_t n_off = report.n_outside + report.n_in_gaps;
  if (n_off > 0)
    session.warn(fmt::format("{} of {} places have no height: {} outside, {} in gaps", n_off,
                             places.size(), report.n_outside, report.n_in_gaps));
  if (!arguments.output.empty())
    LODE_CHECK(write_text(arguments.output, height_csv(answer), session.progress()));
  return outcome_of(answer, session);
}

}  // namespace

Command add_height_command(CLI::App& program) {
  auto arguments = std::make_shared<HeightArguments>();
  arguments->terrain.is_closed = true;
  CLI::App* app =
      program.add_subcommand("height", "Show heights of a terrain at places, with their bounds");
  app->footer(
      "The height is that of the TIN within --max-error, in its triangle's plane. `bound` holds\n"
      "at samples: none in the triangle is farther from its plane. With --everywhere it holds\n"
      "between samples, too, where terrain is taken for linear on two triangles a cell, as it is\n"
      "at full resolution. Of surface quadtrees (bilinear) and quaternary triangulations it is "
      "that\n"
      "of the square or triangle that holds the place, of several the smallest.\n"
      "Places outside of the terrain, or in its gaps, have no height, and are counted.\n"
      "POINTS.csv has x and y a line, in the raster's CRS or that of --places-crs, with a heading\n"
      "(x,y or lon,lat) or without. Rows that come have x and y as they are given.\n\n"
      "Examples:\n  lode height dem.tif --at 500010,4000020 --max-error 1\n"
      "  lode height dem.tif stations.csv --out heights.csv --max-error 0\n"
      "  lode height utm.tif gps.csv --places-crs EPSG:4326 --max-error 1");
  add_terrain_query(*app, arguments->terrain);
  add_everywhere(*app, arguments->terrain);
  add_asked_places(*app, arguments->places);
  app->add_option("-o,--output,--out", arguments->output, "Write x,y,height,bound,bound_kind")
      ->type_name("OUT.csv");
  return {app, [arguments] { return check_height(*arguments); },
          [arguments](Session& session) { return run_height(*arguments, session); }};
}

}  // namespace lode::cli
