#include <memory>

#include "build_terrain.h"
#include "command.h"
#include "comparison_page.h"
#include "input.h"
#include "outputs.h"
#include "parse.h"
#include "terrain_facts.h"
#include "terrain_input.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

constexpr std::int64_t kMostRuns = 1000;

struct CompareArguments {
  std::string input;
  std::string output;
  std::string tolerances;
  std::string runs = "3";
  std::string seed = "1";
  std::string memory_limit;
  ReadingArguments reading;
  TerrainArguments terrain;
};

Result<ComparisonOptions> to_options(const CompareArguments& arguments) {
  ComparisonOptions options;
  LODE_TRY(ToleranceList tolerances, parse_tolerances("--tolerances", arguments.tolerances));
  options.tolerances = std::move(tolerances.values);
  LODE_TRY(const auto runs, parse_integer("--runs", arguments.runs, 1, kMostRuns));
  options.n_runs = static_cast<int>(runs);
  LODE_TRY(const auto seed, parse_integer("--seed", arguments.seed, 0, INT64_MAX));
  options.seed = static_cast<std::uint64_t>(seed);
  if (!arguments.memory_limit.empty()) {
    LODE_TRY(options.memory_limit, parse_bytes("--memory-limit", arguments.memory_limit));
  }
  return options;
}

Result<void> check_compare(const CompareArguments& arguments) {
  if (!is_terrain_path(arguments.input))
    return fail("{}: expected {}, got another file", arguments.input, kTerrainFiles);
  LODE_CHECK(check_extension(arguments.output, ".html"));
  if (auto options = to_options(arguments); !options) return options.error();
  LODE_CHECK(check_terrain_reading(arguments.input, arguments.terrain, arguments.reading));
  return check_paths_differ({arguments.input}, {arguments.output});
}

std::string table_of(const TerrainComparison& comparison, const std::string& output) {
  Table table;
  for (const ComparedModel& model : comparison.models) {
    if (!model.refusal.empty()) table.add({model.name, "not run: " + model.refusal});
    for (const ComparedMesh& mesh : model.meshes)
      table.add(
          {model.name, fmt::format("within {}: {} triangles, true error {}, RMS {}, in {}",
                                   format_number(mesh.tolerance), format_count(mesh.triangles),
                                   format_number(mesh.quality.worst_error),
                                   format_number(mesh.quality.rms_error),
                                   format_seconds(mesh.extract_seconds))});
  }
  table.add({"in all", format_seconds(comparison.seconds)});
  table.add({"output", output});
  return table.to_string();
}

Result<Outcome> run_compare(const CompareArguments& arguments, Session& session) {
  LODE_TRY(ComparisonOptions options, to_options(arguments));
  options.threads = session.threads();
  LODE_CHECK(check_writable(arguments.output));
  LODE_TRY(const OpenedTerrain opened,
           open_terrain(arguments.input, arguments.terrain, arguments.reading, {}, {}, session));
  const HeightRange range = opened.terrain.range();
  if (is_share(arguments.tolerances))
    for (double& tolerance : options.tolerances) tolerance *= range.upper - range.lower;
  auto comparison = opened.points ? compare_terrain(*opened.points, options, session.progress())
                                  : compare_terrain(*opened.grid, options, session.progress());
  if (!comparison) {
    if (session.progress().is_cancelled()) return comparison.error();
    return fail("{}: {}", arguments.input, comparison.error().message);
  }
  Outcome outcome;
  Json& json = outcome.json;
  Table unused;
  json["command"] = "compare";
  json["input"] = arguments.input;
  json["outputs"] = Json::array({arguments.output});
  add_facts(opened.facts, json, unused);
  json["range"] = {comparison->range.lower, comparison->range.upper};
  json["runs"] = options.n_runs;
  json["seed"] = options.seed;
  json["memory_limit"] = comparison->memory_limit;
  json["models"] = comparison_json(*comparison);
  json["angles_are_in"] =
      is_in_angles(opened.facts.frame.crs) ? "plane of longitudes and latitudes" : "plane";
  json["seconds"] = {{"total", comparison->seconds}};
  json["warnings"] = session.warnings();
  const HeightFrame& frame = opened.facts.frame;
  const ComparedRaster about{
      arguments.input,
      opened.points ? format_count(opened.points->points.nodes.size()) + " scattered points"
                    : fmt::format("{} x {}", frame.n_columns, frame.n_rows),
      frame.vertical_unit,
      fmt::format("{} of {} runs each", options.n_runs == 1 ? "times" : "medians", options.n_runs),
      is_in_angles(frame.crs)};
  LODE_CHECK(
      write_text(arguments.output, comparison_page(*comparison, about, json), session.progress()));
  outcome.text = table_of(*comparison, arguments.output);
  return outcome;
}

}  // namespace

Command add_compare_command(CLI::App& program) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* app = program.add_subcommand(
      "compare", "Run all models of terrain on a raster or points, and report how they do");
  app->footer(
      "Each model makes a mesh within each tolerance. True errors, shapes of triangles, and times\n"
      "of extraction, contours, heights, profiles and steps over edges are measured on the meshes\n"
      "alike. The report is one page with tables, plots and all numbers as JSON. Of scattered\n"
      "points errors are at points, and models that need a raster are listed as not run.\n\n"
      "Examples:\n  lode compare dem.tif report.html --tolerances 50,20,10,5\n"
      "  lode compare survey.las report.html --class 2 --tolerances 1,0.2");
  app->add_option("dem", arguments->input,
                  "Raster of heights (.tif, .asc, .hgt, .nc, .png, ...) or scattered points (.las, "
                  ".xyz, ...)")
      ->type_name("DEM")
      ->required();
  app->add_option("report", arguments->output, "Page to write")->type_name("OUT.html")->required();
  app->add_option("--tolerances", arguments->tolerances,
                  "Vertical errors, in units of the heights, or all with % of their range")
      ->type_name("A,B,...")
      ->required();
  app->add_option("--runs", arguments->runs, "Of what takes time; the median counts (default: 3)")
      ->type_name("N");
  app->add_option("--seed", arguments->seed, "Of the places for heights (default: 1)")
      ->type_name("N");
  app->add_option("--memory-limit", arguments->memory_limit,
                  "Memory for links between levels, such as 512M (default: a quarter of the "
                  "machine's); a model that takes more is not run")
      ->type_name("BYTES");
  app->add_option("--nodata", arguments->reading.nodata,
                  "Value of missing samples, instead of the file's")
      ->type_name("V")
      ->group("Rasters of heights");
  add_terrain_options(*app, arguments->terrain, TerrainUse::reading);
  return {app, [arguments] { return check_compare(*arguments); },
          [arguments](Session& session) { return run_compare(*arguments, session); }};
}

}  // namespace lode::cli
