#include "extract_terrain.h"

#include "outputs.h"
#include "parse.h"
#include "stopwatch.h"
#include "terrain_query.h"

namespace lode::cli {
namespace {

/// A raster, the TIN of it, and how long things took.
struct TerrainAnswer {
  const TerrainJob& job;
  const HeightRaster& raster;
  const TerrainReport& report;
  bool is_strict;
  double read_seconds;
  double write_seconds;
};

Json answer_json(const TerrainAnswer& answer, Table& table, const Session& session) {
  const TerrainReport& report = answer.report;
  Json json;
  json["command"] = "extract";
  json["input"] = answer.job.input;
  json["outputs"] = Json::array({answer.job.output});
  json["model"] = kTerrainModel;
  json["insertion"] = answer.is_strict ? "strict" : "levels";
  json["max_error"] = report.max_error;
  json["max_error_is_default"] = answer.job.max_error.empty();
  json["achieved_error"] = report.achieved_error;
  json["error_kind"] = "at samples";
  json["error_met"] = report.is_within_error;
  json["budget_met"] = report.budget_met;
  json["triangles"] = report.triangles;
  json["vertices"] = report.vertices;
  add_raster(answer.raster, json, table);
  json["samples"] = report.n_samples;
  json["left_out_samples"] = report.n_left_out;
  json["height_slack"] = report.height_slack;
  json["position_slack"] = report.position_slack;
  json["seconds"] = {{"total", answer.read_seconds + report.seconds + answer.write_seconds},
                     {"read", answer.read_seconds},
                     {"select", report.seconds},
                     {"write", answer.write_seconds}};
  json["warnings"] = session.warnings();
  return json;
}

void add_rows(const TerrainAnswer& answer, Table& table) {
  const TerrainReport& report = answer.report;
  if (report.n_left_out > 0)
    table.add({"left out", fmt::format("{} samples in no cell with four heights",
                                       format_count(report.n_left_out))});
  table.add({"model", kTerrainModel});
  const char* why = !answer.job.max_error.empty()   ? "as asked"
                    : !answer.job.max_cells.empty() ? "the triangles decide"
                                                    : "default: 0.5 % of the range";
  table.add({"max error", fmt::format("{} ({})", format_number(report.max_error), why)});
  table.add({"achieved error", fmt::format("{} at samples", format_number(report.achieved_error))});
  table.add({"triangles", format_count(report.triangles)});
  table.add({"vertices", format_count(report.vertices)});
  table.add({"read", format_seconds(answer.read_seconds)});
  table.add({"select", format_seconds(report.seconds)});
  table.add({"write", format_seconds(answer.write_seconds)});
  table.add({"output", answer.job.output});
}

std::string comment_of(const TerrainReport& report, const HeightRaster& raster) {
  return fmt::format("Lode {}: {}, max_error {}, achieved_error {} at samples{}{}", LODE_VERSION,
                     kTerrainModel, report.max_error, report.achieved_error,
                     raster.grid.vertical_unit.empty() ? "" : " " + raster.grid.vertical_unit,
                     raster.grid.crs.empty() ? "" : ", CRS " + raster.grid.crs);
}

void warn_of(const TerrainReport& report, const TerrainJob& job, Session& session) {
  constexpr double kMuch = 1e-3;
  if (report.height_slack > kMuch * report.max_error)
    session.warn(
        fmt::format("coordinates are floats: heights of vertices in {} are off by up to {}",
                    job.output, format_number(report.height_slack)));
  if (!report.budget_met)
    session.warn(fmt::format("--max-cells is not met: the outline alone has {} triangles",
                             report.triangles));
  if (!job.max_error.empty() && !report.is_within_error)
    session.warn(fmt::format("--max-error is not met: --max-cells allows {} only",
                             format_number(report.achieved_error)));
}

}  // namespace

Result<TerrainOptions> to_terrain_options(const std::string& max_error,
                                          const std::string& max_cells,
                                          const TerrainArguments& terrain) {
  TerrainOptions options;
  LODE_TRY(options.max_error, to_max_error(max_error));
  if (!terrain.model.empty() && terrain.model != kTerrainModel)
    return fail("--model: expected '{}' for a raster of heights, got '{}'", kTerrainModel,
                terrain.model);
  if (!max_cells.empty()) {
    constexpr std::int64_t kMaxCells = std::int64_t{1} << 30;
    LODE_TRY(const auto n, parse_integer("--max-cells", max_cells, 1, kMaxCells));
    options.max_cells = static_cast<std::uint64_t>(n);
  }
  const std::string& insertion = terrain.insertion;
  if (insertion == "strict") {
    options.order = InsertionOrder::strict;
  } else if (!insertion.empty() && insertion != "levels") {
    return fail("--insertion: expected 'levels' or 'strict', got '{}'", insertion);
  }
  if (insertion == "levels" && options.max_cells)
    return fail("--insertion: expected 'strict' with --max-cells, got 'levels'");
  return options;
}

Result<void> check_terrain_job(const TerrainJob& job, const CLI::App& app) {
  LODE_CHECK(
      check_only_terrain(app, job.input, {"--max-error", "--max-cells", "--model", "--insertion"}));
  LODE_CHECK(check_surface_extension(job.output));
  if (auto options = to_terrain_options(job.max_error, job.max_cells, job.terrain); !options)
    return options.error();
  if (auto options = to_height_options(job.terrain, job.reading); !options) return options.error();
  return check_paths_differ({job.input}, {job.output});
}

Result<Outcome> run_terrain_job(const TerrainJob& job, Session& session) {
  LODE_TRY(const TerrainOptions options,
           to_terrain_options(job.max_error, job.max_cells, job.terrain));
  LODE_TRY(const HeightReadOptions reading, to_height_options(job.terrain, job.reading));
  LODE_CHECK(check_writable(job.output));
  const Stopwatch read_watch;
  LODE_TRY(const HeightRaster raster, read_heights(job.input, reading, session.progress()));
  const double read_seconds = read_watch.seconds();
  LODE_TRY(const TerrainSurface made,
           naming(job.input, extract_terrain(raster.grid, options, session.progress()), session));
  const TerrainReport& report = made.report;
  const Stopwatch write_watch;
  LODE_CHECK(write_surface(job.output, made.surface,
                           {.comment = comment_of(report, raster), .value_name = "height"},
                           session.progress()));
  warn_of(report, job, session);
  const bool is_strict = options.max_cells || options.order == InsertionOrder::strict;
  const TerrainAnswer answer{job, raster, report, is_strict, read_seconds, write_watch.seconds()};
  Table table;
  Outcome outcome;
  outcome.json = answer_json(answer, table, session);
  add_rows(answer, table);
  outcome.text = table.to_string();
  return outcome;
}

Result<Outcome> run_terrain_info(const std::string& path, const TerrainArguments& terrain,
                                 const ReadingArguments& reading, Session& session) {
  LODE_TRY(const HeightReadOptions options, to_height_options(terrain, reading));
  LODE_TRY(const HeightRaster raster, read_heights(path, options, session.progress()));
  const TerrainInfo info = describe_terrain(raster.grid);
  Outcome outcome;
  outcome.json["command"] = "info";
  outcome.json["file"] = path;
  outcome.json["format"] = raster.format;
  Table table;
  table.add({"file", path});
  table.add({"format", raster.format});
  add_raster(raster, outcome.json, table);
  outcome.json["range"] = info.has_heights ? Json::array({info.lower, info.upper}) : Json(nullptr);
  outcome.json["cells"] = info.n_cells;
  outcome.json["left_out_samples"] = info.n_left_out;
  table.add({"range", info.has_heights ? fmt::format("{} to {}", format_number(info.lower),
                                                     format_number(info.upper))
                                       : "none"});
  table.add({"cells", fmt::format("{} with four heights", format_count(info.n_cells))});
  if (info.n_left_out > 0)
    table.add(
        {"left out", fmt::format("{} samples in no such cell", format_count(info.n_left_out))});
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace lode::cli
