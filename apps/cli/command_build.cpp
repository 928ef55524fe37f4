#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <system_error>

#include "build_terrain.h"
#include "build_tetra.h"
#include "command.h"
#include "describe.h"
#include "input.h"
#include "parse.h"
#include "text.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

struct BuildArguments {
  std::string input;
  std::string output;
  std::string memory_limit;
  bool resumes = false;
  bool leaves_nothing = false;
  std::string base_cells;
  std::string boundary_tolerance;
  bool is_everywhere = false;
  bool has_space_errors = false;
  bool is_lean = false;
  bool keeps_extrema = false;
  std::string at;
  std::string levels;
  TerrainArguments terrain;
  ReadingArguments reading;

  [[nodiscard]] TetraBuildJob tetra() const {
    return {input,         output,           base_cells, boundary_tolerance, memory_limit,
            is_everywhere, has_space_errors, is_lean,    keeps_extrema,      at,
            reading};
  }
  [[nodiscard]] TerrainBuildJob of_terrain() const {
    return {input, output, levels, memory_limit, terrain, reading};
  }
};

bool holds_bytes(const std::string& path) {
  std::error_code status;
  return std::filesystem::is_regular_file(path, status) &&
         std::filesystem::file_size(path, status) > 0;
}

/// Of a mesh of cells, which is built in memory at once.
Result<void> check_mesh_build(const BuildArguments& arguments) {
  if (arguments.resumes || arguments.leaves_nothing)
    return fail(
        "{}: expected no --resume or --no-resume with a mesh of cells, which is built in memory",
        arguments.input);
  return check_tetra_build(arguments.tetra());
}

Result<void> check_build(const BuildArguments& arguments, const CLI::App& app) {
  if (is_terrain_path(arguments.input)) return check_terrain_build(arguments.of_terrain(), app);
  LODE_CHECK(check_no_terrain(arguments.terrain, arguments.input));
  if (!arguments.levels.empty())
    return fail(
        "{}: expected a raster of heights or scattered points with --levels, got another "
        "file",
        arguments.input);
  if (is_cells_path(arguments.input)) return check_mesh_build(arguments);
  if (!arguments.base_cells.empty() || !arguments.boundary_tolerance.empty() ||
      arguments.is_everywhere || arguments.has_space_errors || arguments.is_lean ||
      arguments.keeps_extrema || !arguments.at.empty())
    return fail(
        "{}: expected a mesh of cells with --base-cells, --boundary-tolerance, --everywhere, "
        "--keep-extrema, --space-errors, --lean and --at",
        arguments.input);
  // What is no file, or empty, is left to the reader, which says so.
  if (is_lode_path(arguments.input) && holds_bytes(arguments.input))
    return fail("{}: expected a file of another format to build from, got a .lode file",
                arguments.input);
  if (!is_lode_path(arguments.output))
    return fail("{}: expected an output that ends in .lode", arguments.output);
  LODE_CHECK(check_paths_differ({arguments.input}, {arguments.output}));
  if (!arguments.memory_limit.empty())
    if (auto limit = parse_bytes("--memory-limit", arguments.memory_limit); !limit)
      return limit.error();
  if (auto options = to_read_options(arguments.reading, {}); !options) return options.error();
  return {};
}

std::string describe_spool(const FileBuildReport& report) {
  if (report.io.n_spool_bytes_written == 0) return "";
  return fmt::format("; {} spooled, {} read back", format_bytes(report.io.n_spool_bytes_written),
                     format_bytes(report.io.n_spool_bytes_read));
}

Outcome report_build(const BuildArguments& arguments, const FileBuildReport& report) {
  const DatasetInfo& info = report.info;
  const FileBuildSeconds& seconds = report.seconds;
  const auto n_samples = static_cast<std::uint64_t>(info.volume.grid.n_samples());
  const auto n = static_cast<double>(n_samples);
  const double rate = seconds.total > 0 ? n / seconds.total / 1e6 : 0;
  Outcome outcome;
  outcome.json["command"] = "build";
  outcome.json["input"] = arguments.input;
  outcome.json["output"] = arguments.output;
  outcome.json.update(to_json(info));
  outcome.json["file_bytes"] = report.file_bytes;
  outcome.json["memory_limit"] = report.memory_limit;
  outcome.json["parts"] = report.n_parts;
  outcome.json["chunks_resumed"] = report.n_chunks_resumed;
  outcome.json["sample_bytes_read"] = report.samples_bytes_read;
  Json& io = outcome.json["io"];
  io["file_bytes_read"] = report.io.n_file_bytes_read;
  io["spool_bytes_written"] = report.io.n_spool_bytes_written;
  io["spool_bytes_read"] = report.io.n_spool_bytes_read;
  io["bytes_written"] = report.file_bytes;
  Json& json_seconds = outcome.json["seconds"];
  json_seconds["total"] = seconds.total;
  json_seconds["scan"] = seconds.scan;
  json_seconds["read"] = seconds.read;
  json_seconds["build"] = seconds.build;
  json_seconds["write"] = seconds.write;
  Table table;
  table.add({"model", info.model});
  table.add({"samples", format_count(n_samples)});
  table.add({"value range", describe_range(info)});
  table.add({"base error", format_number(info.base_error)});
  add_units(table, info.volume.units);
  table.add({"time", fmt::format("{} ({:.1f} million samples a second)",
                                 format_seconds(seconds.total), rate)});
  table.add(
      {"of which", fmt::format("{} to scan, {} to read again, {} for errors and ranges, {} to "
                               "compress and write",
                               format_seconds(seconds.scan), format_seconds(seconds.read),
                               format_seconds(seconds.build), format_seconds(seconds.write))});
  if (report.n_chunks_resumed > 0)
    table.add({"resumed after", format_count(report.n_chunks_resumed) + " chunks"});
  table.add(
      {"read", fmt::format("{} of the input in {} {}{}", format_bytes(report.io.n_file_bytes_read),
                           format_count(report.n_parts), report.n_parts == 1 ? "part" : "parts",
                           describe_spool(report))});
  table.add(
      {"file size", fmt::format("{} ({:.3f} bytes per sample)", format_bytes(report.file_bytes),
                                static_cast<double>(report.file_bytes) / n)});
  table.add({"output", arguments.output});
  outcome.text = table.to_string();
  return outcome;
}

Result<Outcome> run_build(const BuildArguments& arguments, Session& session) {
  if (is_terrain_path(arguments.input)) return run_terrain_build(arguments.of_terrain(), session);
  if (is_cells_path(arguments.input)) return run_tetra_build(arguments.tetra(), session);
  LODE_TRY(ReadOptions options, to_read_options(arguments.reading, session.threads()));
  LODE_CHECK(check_writable(arguments.output));
  FileBuildOptions build{
      .threads = session.threads(), .unfinished = Unfinished::part, .memory_limit = 0};
  if (arguments.resumes) build.unfinished = Unfinished::resume;
  if (arguments.leaves_nothing) build.unfinished = Unfinished::nothing;
  if (!arguments.memory_limit.empty()) {
    LODE_TRY(build.memory_limit, parse_bytes("--memory-limit", arguments.memory_limit));
  }
  if (build.memory_limit == 0) build.memory_limit = physical_memory() / 4;
  // Samples that fit an eighth of the memory are decoded there, as their build takes less than the
  // rest; others go to a nameless file beside the output.
  options.memory_limit = static_cast<std::size_t>(build.memory_limit / 8);
  options.cache_limit = static_cast<std::size_t>(build.memory_limit / 4);
  options.spool_directory = std::filesystem::absolute(arguments.output).parent_path().string();
  LODE_TRY(auto source, open_volume(arguments.input, options));
  bool has_part = false;
  build.has_part = &has_part;
  auto report =
      build_file_from(arguments.input, *source, arguments.output, build, session.progress());
  if (report) return report_build(arguments, *report);
  if (!has_part || report.error().message.starts_with(part_path(arguments.output)))
    return report.error();
  const std::string leftover = fmt::format(
      "{} holds what was done: the same command with --resume "
      "goes on from there",
      part_path(arguments.output));
  session.set_leftover(leftover);
  return fail("{}; {}", report.error().message, leftover);
}

}  // namespace

/// Of volumes, meshes and terrain.
constexpr HelpFooter kBuildFooter{{{
    {"",
     "  lode build scan.nrrd scan.lode\n"
     "  lode build scan.raw scan.lode --dims 512x512x300 --type int16 --spacing 0.5,0.5,1\n"},
    {"",
     "  lode build wing.vtu wing.lode --field Density\n"
     "  lode build step-0.vtu run.lode --field Density --at 0.5\n"},
    {"",
     "  lode build dem.tif dem.lode --levels 50,20,10,5,2,1\n"
     "  lode build lidar.las dem.lode --class 2 --breaklines dikes.gpkg\n"},
}}};

Command add_build_command(CLI::App& program) {
  auto arguments = std::make_shared<BuildArguments>();
  CLI::App* app = program.add_subcommand(
      "build", "Turn a volume, a mesh of cells or terrain into a .lode file");
  app->add_option("input", arguments->input,
                  "Volume, mesh of cells, raster of heights, or scattered points, to read")
      ->type_name("IN")
      ->required();
  app->add_option("output", arguments->output, "File to write")->type_name("OUT.lode")->required();
  app->add_option("--memory-limit", arguments->memory_limit,
                  "Memory to use, such as 512M or 4G (default: a quarter of the machine's); of a "
                  "mesh, which is built in memory, the most that it may need (default: all); of a "
                  "complete_pyramid or linked_triangle_lists what its links may take (default: 8G)")
      ->type_name("BYTES");
  CLI::Option* resume =
      app->add_flag("--resume", arguments->resumes,
                    "Go on from OUT.lode.part, which a build that was stopped has left");
  app->add_flag("--no-resume", arguments->leaves_nothing, "Leave nothing if the build is stopped")
      ->excludes(resume);
  app->add_option("--base-cells", arguments->base_cells,
                  "Of a mesh: where to stop collapsing (default: a hundredth of its cells)")
      ->type_name("N");
  app->add_option("--boundary-tolerance", arguments->boundary_tolerance,
                  "Of a mesh: how far its boundary, and what lies between its regions, may move "
                  "(default: 0, they stay in their planes)")
      ->type_name("D");
  app->add_flag("--everywhere", arguments->is_everywhere,
                "Of a mesh, by half edges: errors hold at all points (default: at its own vertices "
                "alone); takes a few times as long");
  app->add_flag(
      "--keep-extrema", arguments->keeps_extrema,
      "Of a mesh: vertices with a value above or below all beside them in the mesh itself "
      "stay (default: those that are so when their turn comes)");
  app->add_flag("--space-errors", arguments->has_space_errors,
                "Of a mesh: how far from its place a value may be is found, too, an estimate, for "
                "extract's --max-space-error and --max-error-px; a byte a vertex and field");
  app->add_flag("--lean", arguments->is_lean,
                "Of a mesh, by half edges: leave out of the file what queries do without, some 4 "
                "bytes a vertex: gradients, so normals are those of the cut, and the mesh's "
                "numbers of its vertices, which attach-field takes");
  app->add_option("--at", arguments->at,
                  "Of a mesh: the time of its fields, in any unit, or 'file', as the file says it; "
                  "attach-field adds other steps (default: none)")
      ->type_name("T");
  app->add_option("--levels", arguments->levels,
                  "Of terrain: tolerances of the levels, in units of the heights, or all with % of "
                  "their range; the finest is what questions may ask for (default: a 2000th of the "
                  "range, doubled "
                  "as long as that is below it)")
      ->type_name("E,E,...");
  add_reading_options(*app, arguments->reading);
  add_terrain_options(*app, arguments->terrain, TerrainUse::extraction);
  return {app, [arguments, app] { return check_build(*arguments, *app); },
          [arguments](Session& session) { return run_build(*arguments, session); }, kBuildFooter};
}

}  // namespace lode::cli
