#include <cmath>
#include <memory>

#include "command.h"
#include "input.h"
#include "parse.h"
#include "terrain_input.h"

namespace lode::cli {
namespace {

struct TilesArguments {
  std::string input;
  std::string output;
  std::string max_error;
  std::string max_level;
  std::string fill = "0";
  std::string memory_limit;
  ReadingArguments reading;
  TerrainArguments terrain;
};

Result<TerrainTileOptions> to_options(const TilesArguments& arguments) {
  TerrainTileOptions options;
  LODE_TRY(options.max_error, parse_number("--max-error", arguments.max_error));
  if (!(options.max_error > 0))
    return fail("--max-error: expected a number > 0, got '{}'", arguments.max_error);
  if (!arguments.max_level.empty()) {
    LODE_TRY(const auto level,
             parse_integer("--max-level", arguments.max_level, 0, kMostTileLevels));
    options.max_level = static_cast<int>(level);
  }
  LODE_TRY(options.fill, parse_number("--fill", arguments.fill));
  if (!(std::abs(options.fill) <= kMostTileHeight))
    return fail("--fill: expected a height of at most {} m, got '{}'", kMostTileHeight,
                arguments.fill);
  if (!arguments.memory_limit.empty()) {
    LODE_TRY(options.most_bytes, parse_bytes("--memory-limit", arguments.memory_limit));
  }
  return options;
}

Result<void> check_tiles(const TilesArguments& arguments) {
  if (!is_height_path(arguments.input))
    return fail(
        "{}: expected a raster of heights (.tif, .asc, .hgt, .nc, .png, ...), got another file",
        arguments.input);
  if (auto options = to_options(arguments); !options) return options.error();
  if (auto options = to_height_options(arguments.terrain, arguments.reading); !options)
    return options.error();
  return check_paths_differ({arguments.input}, {arguments.output});
}

void add_levels(const TerrainTileReport& report, Json& json, Table& table) {
  json["levels"] = Json::array();
  for (std::size_t level = 0; level < report.levels.size(); ++level) {
    const TerrainTileReport::Level& one = report.levels[level];
    json["levels"].push_back({{"level", level},
                              {"tiles", one.n_tiles},
                              {"triangles", one.n_triangles},
                              {"vertices", one.n_vertices},
                              {"bytes", one.n_bytes},
                              {"max_error", one.max_error},
                              {"achieved_error", one.error},
                              {"height_step", one.height_step},
                              {"tiles_beyond", one.n_beyond}});
    table.add(
        {fmt::format("level {}", level),
         fmt::format("{} tiles, {} triangles, {}, error {} m of {}", format_count(one.n_tiles),
                     format_count(one.n_triangles), format_bytes(one.n_bytes),
                     format_number(one.error), format_number(one.max_error))});
  }
}

void add_resampling(const TerrainTileReport& report, Json& json, Table& table) {
  if (!report.resampling) return;
  const auto& error = *report.resampling;
  json["resampling"] = {{"samples", error.n_measured},
                        {"outside", error.n_outside},
                        {"max_error", error.largest},
                        {"rms_error", error.rms},
                        {"unit", report.frame.vertical_unit}};
  table.add({"resampled",
             fmt::format("the file's samples are up to {} {} from that, RMS {}, {} of {} measured",
                         format_number(error.largest),
                         report.frame.vertical_unit.empty() ? "units" : report.frame.vertical_unit,
                         format_number(error.rms), format_count(error.n_measured),
                         format_count(error.n_measured + error.n_outside))});
}

void warn_of(const TerrainTileReport& report, const std::string& path, Session& session) {
  for (const std::string& note : report.notes) session.warn(fmt::format("{}: {}", path, note));
  warn_of_vertical(report.vertical, path, session);
  for (std::size_t level = 0; level < report.levels.size(); ++level)
    if (report.levels[level].n_beyond > 0)
      session.warn(fmt::format(
          "level {}: {} tiles are beyond {} m, by up to {} m: places in a tile are whole numbers "
          "up to 32767, and its heights steps of {} m",
          level, report.levels[level].n_beyond, format_number(report.levels[level].max_error),
          format_number(report.levels[level].error),
          format_number(report.levels[level].height_step)));
}

Result<Outcome> run_tiles(const TilesArguments& arguments, Session& session) {
  LODE_TRY(TerrainTileOptions options, to_options(arguments));
  LODE_TRY(const HeightReadOptions reading,
           to_height_options(arguments.terrain, arguments.reading));
  options.threads = session.threads();
  LODE_TRY(
      const TerrainTileReport report,
      write_terrain_tiles(arguments.input, reading, options, arguments.output, session.progress()));
  warn_of(report, arguments.input, session);
  Outcome outcome;
  Json& json = outcome.json;
  Table table;
  json["command"] = "tiles";
  json["input"] = arguments.input;
  json["outputs"] = Json::array({arguments.output});
  json["format"] = "quantized-mesh-1.0";
  json["max_error"] = options.max_error;
  json["fill"] = options.fill;
  json["size"] = {report.frame.n_columns, report.frame.n_rows};
  json["missing_samples"] = report.n_missing;
  table.add({"raster",
             fmt::format("{} x {} {}", report.frame.n_columns, report.frame.n_rows, report.type)});
  if (report.n_missing > 0)
    table.add(
        {"missing", fmt::format("{} samples, as high as --fill", format_count(report.n_missing))});
  add_resampling(report, json, table);
  add_levels(report, json, table);
  table.add({"read", format_seconds(report.read_seconds)});
  table.add({"build", format_seconds(report.build_seconds)});
  table.add({"output", arguments.output});
  json["seconds"] = {{"total", report.read_seconds + report.build_seconds},
                     {"read", report.read_seconds},
                     {"build", report.build_seconds}};
  json["warnings"] = session.warnings();
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace

Command add_tiles_command(CLI::App& program) {
  auto arguments = std::make_shared<TilesArguments>();
  CLI::App* app = program.add_subcommand(
      "tiles", "Cut a raster of heights into quantized-mesh tiles for globes in browsers");
  app->footer(
      "OUT gets Z/X/Y.terrain and layer.json, as Cesium and others load them from any web server.\n"
      "No sample is farther, vertically, from the finest tiles than --max-error, which doubles "
      "with\n"
      "each coarser level; nor than what clients take a level's error to be, 77067 / 2^Z metres.\n"
      "Errors are measured on what is written, and are in layer.json. Tiles of a level meet "
      "without\n"
      "cracks.\n\n"
      "The raster has to be in degrees, or is put there: --resample. Heights are to be above the\n"
      "ellipsoid: where the file or --vertical-crs says that they are above something else, they\n"
      "are transformed.\n\n"
      "Example:\n  lode tiles N35W119.hgt tiles --max-error 2 --vertical-crs EPSG:5773\n"
      "  lode tiles utm.tif tiles --max-error 2 --resample cubic\n"
      "  lode verify tiles --against utm.tif --resample cubic");
  app->add_option("dem", arguments->input, "Raster of heights (.tif, .asc, .hgt, .nc, .png, ...)")
      ->type_name("DEM")
      ->required();
  app->add_option("folder", arguments->output, "Folder to make; may be there, if it is empty")
      ->type_name("OUT")
      ->required();
  app->add_option("--max-error", arguments->max_error, "Vertical, of the finest level, in metres")
      ->type_name("E")
      ->required();
  app->add_option("--max-level", arguments->max_level,
                  "Finest level (default: the first whose tiles have at most 256 samples a side)")
      ->type_name("Z");
  app->add_option("--fill", arguments->fill,
                  "Metres above the ellipsoid where there are no samples (default: 0)")
      ->type_name("H");
  app->add_option("--memory-limit", arguments->memory_limit,
                  "Samples that take more stay in their file, which is then read several times "
                  "(default: 512M); not of .hgt files")
      ->type_name("BYTES");
  app->add_option("--nodata", arguments->reading.nodata,
                  "Value of missing samples, instead of the file's")
      ->type_name("V")
      ->group("Rasters of heights");
  add_terrain_options(*app, arguments->terrain, TerrainUse::rasters);
  add_resample_option(*app, arguments->terrain);
  return {app, [arguments] { return check_tiles(*arguments); },
          [arguments](Session& session) { return run_tiles(*arguments, session); }};
}

}  // namespace lode::cli
