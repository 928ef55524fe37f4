#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "command.h"
#include "describe.h"
#include "extract_focused.h"
#include "extract_progressive.h"
#include "extract_terrain.h"
#include "extract_tetra.h"
#include "extraction_options.h"
#include "input.h"
#include "outputs.h"
#include "parse.h"
#include "salvage.h"
#include "simplify_options.h"
#include "tetra_input.h"
#include "text.h"
#include "to_crs.h"
#include "tolerance.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

struct ExtractArguments {
  std::string input;
  std::string output;
  std::string memory_limit;
  ExtractionArguments extraction;
  QueryArguments query;
  ProgressiveArguments progressive;
  SimplifyArguments simplify;
  ReadingArguments reading;
  TerrainFocusArguments focus;
  RasterArguments raster;
  TerrainArguments terrain;

  /// What is simplified within a distance is of full resolution unless something else is asked for.
  [[nodiscard]] ExtractionArguments plain() const {
    ExtractionArguments all = extraction;
    const bool has_distance = !simplify.max_distance.empty();
    if (simplify.is_wanted() && has_distance && all.max_error.empty()) all.max_error = "0";
    return all;
  }

  [[nodiscard]] MeshJob mesh_job() const {
    return {input, output, memory_limit, extraction, query, reading};
  }
  [[nodiscard]] TerrainJob terrain_job() const {
    return {input,   output, extraction.max_error, extraction.clip, query, focus, raster,
            terrain, reading};
  }
};

Result<void> check_extract(const ExtractArguments& arguments, const CLI::App& app) {
  if (holds_terrain(arguments.input)) return check_terrain_job(arguments.terrain_job(), app);
  LODE_CHECK(check_no_terrain(arguments.terrain, arguments.input));
  if (!arguments.focus.is_empty())
    return fail(
        "{}: expected terrain with --focus-point, --growth or --exaggeration, got another file",
        arguments.input);
  LODE_CHECK(check_no_raster(arguments.raster, arguments.input));
  LODE_CHECK(check_unused(arguments.query, holds_tetrahedra(arguments.input)));
  if (arguments.reading.salvage && !arguments.memory_limit.empty())
    return fail("--salvage: expected no --memory-limit with it: all of the file is loaded");
  if (!arguments.memory_limit.empty()) {
    if (auto limit = parse_bytes("--memory-limit", arguments.memory_limit); !limit)
      return limit.error();
    if (arguments.progressive.is_wanted())
      return fail("--memory-limit: expected no --progressive with it, which loads the whole file");
  }
  if (arguments.progressive.is_wanted() &&
      (arguments.query.is_wanted() || arguments.query.is_focused()))
    return fail("--progressive: expected no --mesh, --section, focus, budget or deadline with it");
  if (!arguments.simplify.max_distance.empty() && !arguments.simplify.is_wanted() &&
      (arguments.progressive.is_wanted() || arguments.query.is_wanted() ||
       arguments.query.is_focused()))
    return fail(
        "--max-distance: expected no --mesh, --section, focus, budget, deadline or --progressive "
        "with it");
  if (arguments.simplify.is_wanted() &&
      (arguments.progressive.is_wanted() || arguments.query.is_wanted() ||
       arguments.query.is_focused()))
    return fail(
        "{}: expected no --mesh, --section, focus, budget, deadline or --progressive with it",
        arguments.simplify.name());
  if (holds_cells(arguments.input)) {
    if (arguments.reading.salvage)
      return fail("--salvage: expected a volume's file, {} holds a mesh of cells", arguments.input);
    if (arguments.simplify.is_wanted() || !arguments.simplify.max_distance.empty() ||
        arguments.progressive.is_wanted())
      return fail(
          "{}: expected no --simplify, --max-distance or --progressive with a mesh of cells",
          arguments.input);
    return check_tetra_job(arguments.mesh_job());
  }
  if (!arguments.query.warp.is_empty())
    return fail("--warp: expected a mesh of cells, got {}", arguments.input);
  if (!arguments.query.patches.empty())
    return fail("--patch: expected a mesh of cells, got {}", arguments.input);
  if (!arguments.query.regions.empty())
    return fail("--region: expected a mesh of cells, got {}", arguments.input);
  if (arguments.query.is_wanted()) return check_mesh_job(arguments.mesh_job());
  if (arguments.query.is_focused()) return check_focused_job(arguments.mesh_job());
  LODE_TRY(ExtractOptions options, to_extract_options(arguments.plain()));
  LODE_CHECK(apply_simplify_options(arguments.simplify, options));
  if (options.isovalues.empty()) return no_isovalue(arguments.input, arguments.reading);
  LODE_CHECK(check_surface_extension(arguments.output));
  LODE_CHECK(check_isovalues_of(arguments.output, options.isovalues));
  LODE_CHECK(check_reading_options(arguments.reading, arguments.input));
  LODE_CHECK(check_progressive(arguments.progressive, arguments.extraction));
  return check_paths_differ({arguments.input},
                            paths_for_isovalues(arguments.output, options.isovalues));
}

/// Sums of the jobs' reports; errors are the largest of them.
struct Totals {
  ExtractReport report;

  void add_simplified_job(const ExtractReport& job) {
    if (!job.simplified) return;
    if (!report.simplified) report.simplified.emplace();
    report.simplified->join(*job.simplified);
    report.seconds.simplify += job.seconds.simplify;
  }
  void add_distance_of(const ExtractReport& job) {
    if (!job.distance) return;
    if (!report.distance) report.distance.emplace();
    DistanceReport& all = *report.distance;
    all.max_distance = job.distance->max_distance;
    all.memory_limit = job.distance->memory_limit;
    all.proven_distance = std::max(all.proven_distance, job.distance->proven_distance);
    all.rounds += job.distance->rounds;
    all.nodes_refined += job.distance->nodes_refined;
    all.full_triangles += job.distance->full_triangles;
    all.lost_triangles += job.distance->lost_triangles;
    all.lost_size = std::max(all.lost_size, job.distance->lost_size);
    report.seconds.distance += job.seconds.distance;
  }
  void add_topology_of(const ExtractReport& job) {
    if (!job.topology) return;
    if (!report.topology)
      report.topology = KeptTopology{.persistence = job.topology->persistence,
                                     .is_searched = job.topology->is_searched,
                                     .leaves_out_weak = job.topology->leaves_out_weak};
    report.topology->critical_nodes += job.topology->critical_nodes;
    report.topology->nodes += job.topology->nodes;
    report.topology->weak_regions += job.topology->weak_regions;
    report.seconds.topology += job.seconds.topology;
  }
  void add(const ExtractReport& job) {
    report.max_error = job.max_error;
    report.achieved_error = std::max(report.achieved_error, job.achieved_error);
    report.coordinate_slack = std::max(report.coordinate_slack, job.coordinate_slack);
    report.style_error = std::max(report.style_error, job.style_error);
    report.style_distance = std::max(report.style_distance, job.style_distance);
    report.triangles += job.triangles;
    report.lines += job.lines;
    report.vertices += job.vertices;
    report.nodes_visited += job.nodes_visited;
    report.bytes_read += job.bytes_read;
    report.cap_cells += job.cap_cells;
    report.components_dropped += job.components_dropped;
    report.triangles_dropped += job.triangles_dropped;
    add_simplified_job(job);
    add_topology_of(job);
    add_distance_of(job);
    report.seconds.total += job.seconds.total;
    report.seconds.select += job.seconds.select;
    report.seconds.geometry += job.seconds.geometry;
    report.seconds.finish += job.seconds.finish;
    report.seconds.measure += job.seconds.measure;
    report.seconds.write += job.seconds.write;
  }
};

/// What is reported of one extraction.
struct Extraction {
  const ExtractArguments& arguments;
  const ExtractOptions& options;
  const Input& input;
  std::vector<std::string> outputs;
  Totals totals;
  Json steps{};  ///< With --progressive.

  [[nodiscard]] bool is_lines() const { return input.info.model == "diamond2d"; }
};

Json extraction_json(const Extraction& extraction, const std::vector<std::string>& warnings) {
  const ExtractReport& report = extraction.totals.report;
  Json json = extract_head(extraction.arguments.input, extraction.input, extraction.outputs);
  add_extraction(json, extraction.options, report);
  json["coordinate_slack"] = report.coordinate_slack;
  json["nodes_visited"] = report.nodes_visited;
  json["bytes_read"] = report.bytes_read;
  json["components_dropped"] = report.components_dropped;
  json["triangles_dropped"] = report.triangles_dropped;
  if (extraction.steps.contains("steps")) json["steps"] = extraction.steps["steps"];
  Json& seconds = json["seconds"];
  seconds["total"] = report.seconds.total;
  seconds["select"] = report.seconds.select;
  seconds["geometry"] = report.seconds.geometry;
  seconds["finish"] = report.seconds.finish;
  if (extraction.options.style == SurfaceStyle::cubes) seconds["measure"] = report.seconds.measure;
  seconds["open"] = extraction.input.open_seconds;
  seconds["write"] = report.seconds.write;
  add_distance(json, report);
  add_simplified(json, report);
  add_salvage(json, extraction.input.dataset.salvaged(), report.achieved_error);
  json["warnings"] = warnings;
  return json;
}

std::string extraction_text(const Extraction& extraction) {
  const ExtractReport& report = extraction.totals.report;
  const bool is_lines = extraction.is_lines();
  Table table;
  add_isovalues(extraction.options.isovalues, table);
  table.add({"max error", describe_tolerance(extraction.options, report.max_error)});
  const char* const when = report.simplified ? ", before it was simplified" : "";
  table.add({"achieved error", format_number(report.achieved_error) + when});
  table.add({"coordinate slack", format_number(report.coordinate_slack)});
  add_units(table, extraction.input.info.volume.units);
  if (report.topology) table.add({"topology", describe_topology(report)});
  add_style(extraction.options, report, extraction.input.info.n_holes > 0, table);
  add_salvage(table, extraction.input.dataset.salvaged(), report.achieved_error);
  table.add(
      {is_lines ? "lines" : "triangles", format_count(is_lines ? report.lines : report.triangles)});
  table.add({"vertices", format_count(report.vertices)});
  if (extraction.options.border == Border::closed)
    table.add({"caps at the border", format_count(report.cap_cells)});
  table.add({"nodes visited", format_count(report.nodes_visited)});
  if (report.bytes_read > 0)
    table.add({"read", fmt::format("{} of blocks", format_bytes(report.bytes_read))});
  add_dropped(extraction.options, report.components_dropped, report.triangles_dropped, is_lines,
              table);
  add_distance(table, report);
  add_simplified(table, report);
  table.add({"extract", fmt::format("{} (select {:.3f}, geometry {:.3f}, finish {:.3f})",
                                    format_seconds(report.seconds.total), report.seconds.select,
                                    report.seconds.geometry, report.seconds.finish)});
  table.add({extraction.input.was_built ? "read and build" : "open",
             format_seconds(extraction.input.open_seconds)});
  table.add({"write", format_seconds(report.seconds.write)});
  if (extraction.steps.contains("steps"))
    table.add({"steps", format_count(extraction.steps["steps"].size())});
  for (const std::string& path : extraction.outputs) table.add({"output", path});
  return table.to_string();
}

/// What files say of themselves.
SurfaceWriteOptions note_of(const ExtractReport& report, const std::vector<double>& isovalues,
                            const ExtractOptions& options, const Input& input) {
  return {.comment = fmt::format(
              "Lode {}: {} {}, max_error {}, achieved_error {}{}{}{}{}{}{}{}", LODE_VERSION,
              isovalues.size() == 1 ? "isovalue" : "isovalues", fmt::join(isovalues, " "),
              report.max_error, report.achieved_error,
              report.simplified ? " before it was simplified" : "",
              options.style == SurfaceStyle::cubes
                  ? fmt::format(", style cubes{}, style_error {}",
                                options.style_distance
                                    ? fmt::format(" within {}", *options.style_distance)
                                    : "",
                                report.style_error)
                  : "",
              topology_comment(report), distance_comment(report), simplify_comment(report),
              units_comment(input), salvage_comment(input.dataset.salvaged())),
          .frame = input.info.volume.grid.frame,
          .threads = options.threads};
}

void add_job(const ExtractReport& report, const ExtractOptions& options, const Input& input,
             Session& session, Totals& totals) {
  totals.add(report);
  warn_of_open(session, report);
  warn_of_persistence(session, report, options, input.info);
  warn_of_unmet(session, report, options, input.info);
}

/// Simplified by themselves surfaces keep to their bands, which may be one in places.
void warn_of_common_bands(Session& session, std::vector<double> isovalues,
                          const ExtractReport& report) {
  std::ranges::sort(isovalues);
  const double width = 2 * (report.max_error + report.coordinate_slack);
  const auto near = std::ranges::adjacent_find(
      isovalues, [width](double lower, double upper) { return upper - lower <= width; });
  if (near == isovalues.end()) return;
  session.warn(fmt::format(
      "each isovalue is simplified by itself within its max error of {}: surfaces of {} and {}, "
      "which are no farther apart than two of that, may pass through each other",
      report.max_error, *near, *std::next(near)));
}

/// Of more than one path each has an isovalue of its own.
Result<void> extract_to_paths(const std::vector<std::string>& paths, const ExtractOptions& options,
                              const Input& input, Session& session, Totals& totals) {
  bool is_together = false;
  if (paths.size() > 1) {
    LODE_TRY(is_together,
             are_extracted_together(input.dataset, options, paths.front(), session.progress()));
  }
  if (is_together) {
    const auto note = [&](const ExtractReport& report, double isovalue) {
      return note_of(report, {isovalue}, options, input);
    };
    LODE_TRY(const ExtractReport report,
             extract_to_files(input.dataset, options, paths, note, session.progress()));
    add_job(report, options, input, session, totals);
    return {};
  }
  for (std::size_t i = 0; i < paths.size(); ++i) {
    ExtractOptions alone = options;
    if (paths.size() > 1) alone.isovalues = {options.isovalues[i]};
    const auto note = [&](const ExtractReport& report) {
      return note_of(report, alone.isovalues, options, input);
    };
    LODE_TRY(const ExtractReport report,
             extract_to_file(input.dataset, alone, paths[i], note, session.progress()));
    add_job(report, options, input, session, totals);
  }
  if (paths.size() > 1 && !input.dataset.takes_several_isovalues(options))
    warn_of_common_bands(session, options.isovalues, totals.report);
  return {};
}

Result<Outcome> run_plain(const ExtractArguments& arguments, Session& session) {
  LODE_TRY(ExtractOptions options, to_extract_options(arguments.plain()));
  LODE_CHECK(apply_simplify_options(arguments.simplify, options));
  options.threads = session.threads();
  options.deviation = Deviation::measured;
  if (!arguments.memory_limit.empty()) {
    LODE_TRY(options.memory_limit, parse_bytes("--memory-limit", arguments.memory_limit));
  }
  const std::vector<std::string> paths = paths_for_isovalues(arguments.output, options.isovalues);
  for (const std::string& path : paths) LODE_CHECK(check_writable(path));
  LODE_TRY(OutputFolder folder, OutputFolder::make(arguments.progressive.directory));
  const auto accept = [&](const VolumeInfo& volume) {
    return check_holds(arguments.output, volume);
  };
  LODE_TRY(const Input input, open_input(session, arguments.input, arguments.reading, accept));
  set_share(arguments.extraction.max_error, input.info.range_min, input.info.range_max,
            options.max_error);
  set_share(arguments.extraction.keep_topology, input.info.range_min, input.info.range_max,
            options.keep_topology);
  warn_of_coordinates(session, input.info.volume.grid);
  warn_of_limit(session, arguments.memory_limit, input);
  LODE_CHECK(check_simplify_range(options, input.info.range_min, input.info.range_max));
  Totals totals;
  OutputSet outputs(paths);
  Json steps;
  if (arguments.progressive.is_wanted()) {
    LODE_TRY(steps, write_steps({folder, arguments.output, options, input}, session, outputs));
  }
  for (const std::string& path : paths) outputs.add(path);
  LODE_CHECK(extract_to_paths(paths, options, input, session, totals));
  warn_of_cubes(session, options);
  outputs.keep();
  folder.keep();
  const Extraction extraction{arguments, options, input, outputs.paths(), totals, steps};
  return Outcome{extraction_json(extraction, session.warnings()), extraction_text(extraction)};
}

Result<Outcome> run_extract(const ExtractArguments& arguments, Session& session) {
  if (holds_terrain(arguments.input)) return run_terrain_job(arguments.terrain_job(), session);
  if (holds_cells(arguments.input)) return run_tetra_job(arguments.mesh_job(), session);
  auto outcome = arguments.query.is_wanted()    ? run_mesh_job(arguments.mesh_job(), session)
                 : arguments.query.is_focused() ? run_focused_job(arguments.mesh_job(), session)
                                                : run_plain(arguments, session);
  if (outcome || arguments.reading.salvage) return outcome;
  return suggest_salvage(outcome.error(), arguments.input);
}

/// Of volumes, meshes and terrain.
constexpr HelpFooter kFooter{{{
    {"OUT may end in .ply, .stl, .obj, .vtp or .glb. Several isovalues share one file; STL and\n"
     "OBJ, which cannot tell them apart, get one each: bone-300.stl, bone-1200.stl, of one cut.\n\n"
     "Of a .lode file larger than --memory-limit no more is loaded than the surface needs, and\n"
     ".ply, .stl and .vtp are written piece by piece: the surface need not fit in memory, unless\n"
     "--clip, --close-border, --min-component, or a --simplify of more than one isovalue, are to\n"
     "see all of it.\n\n"
     "--mesh writes .vtu, --section the surface formats; values and errors need .vtp or .ply.\n",
     "  lode extract scan.lode bone.ply --isovalue 1200 --max-error 10\n"
     "  lode extract scan.lode bone.ply --isovalue 1200 --max-error 0 --style cubes\n"
     "  lode extract scan.lode seen.ply --isovalue 1200 --view camera.json --max-error-px 1\n"
     "  lode extract scan.lode bone.ply --isovalue 1200 --max-distance 0.5\n"
     "  lode extract scan.lode bone.ply --isovalue 1200 --max-error 40 --keep-topology\n"
     "  lode extract scan.lode bone.ply --isovalue 1200 --simplify --max-error 10\n"
     "  lode extract scan.lode bone.ply --isovalue 1200 --simplify --max-distance 0.5\n"
     "  lode extract scan.lode scan.vtu --mesh --field-range 300:900 --max-error 10\n"
     "  lode extract scan.lode cut.vtp --section 0,0,12:0,0,1\n"
     "  lode extract scan.lode bone.vtp --isovalue 1200 --progressive bone-steps\n"
     "  lode extract damaged.lode bone.ply --isovalue 1200 --max-error 10 --salvage\n"},
    {"Of meshes of cells (.vtu, .vts, .vtk, .msh, .mesh, and what lode-vtk-import reads) there "
     "are\n"
     "isosurfaces (.ply, .stl, .obj, .vtp, .glb), --mesh (.vtu, .vtk, .msh, .exo), --section and\n"
     "--boundary (values and errors need .vtp or .ply), with foci and --max-cells. Of others than\n"
     ".lode files the hierarchy is built in memory first.\n",
     "  lode extract wing.lode shock.vtp --isovalue 2.1 --max-error 1%\n"
     "  lode extract wing.lode tip.vtu --mesh --box 3,4,0,1,0,1 --max-cells 100000\n"
     "  lode extract fin.vtu hot.vtp --boundary --threshold 2:5 --field Density\n"
     "  lode extract wing.lode cut.vtp --section 0,0,1,0.5 --isovalue 2.1 --isovalue 2.2\n"},
    {"Of rasters of heights (.tif, .asc, .hgt, .nc, ...) and scattered points (.las, .xyz, ...)\n"
     "there is a TIN: no sample is farther from it, vertically, than --max-error. Of .lode files "
     "of\n"
     "rasters, and with --model delaunay_pyramid, that may hold in a --box X0,X1,Y0,Y1 alone,\n"
     "vary, or be in pixels of a picture through the --view of a camera that lode render writes,\n"
     "in metres from the raster's middle. OUT may end in .tif, too: the TIN's heights on the\n"
     "raster's own grid, or on one of pixels of --cell; within --max-error of every sample also\n"
     "after rounding.\n",
     "  lode extract dem.tif dem.ply --max-error 10\n"
     "  lode extract dem.lode part.ply --max-error 1 --clip 560000,561000,5115000,5116000\n"
     "  lode extract degrees.tif metres.ply --max-error 10 --to-crs EPSG:32632\n"
     "  lode extract dem.tif near.tif --max-error 10 --difference less.tif\n"
     "  lode extract survey.las ground.tif --class 2 --max-error 0.1 --cell 1\n"
     "  lode extract dem.lode dem.ply --max-error 1 --focus-point 562000,5117000 --growth 0.002\n"
     "  lode extract dem.lode seen.ply --view camera.json --max-error-px 1\n"},
}}};

}  // namespace

Command add_extract_command(CLI::App& program) {
  auto arguments = std::make_shared<ExtractArguments>();
  CLI::App* app = program.add_subcommand(
      "extract", "Extract isosurfaces (contour lines of 2D data), meshes, sections or terrain");
  app->add_option("file", arguments->input,
                  ".lode file, a volume or mesh to build in memory, or terrain")
      ->type_name("FILE")
      ->required();
  app->add_option("output", arguments->output, "Surface to write")->type_name("OUT")->required();
  app->add_option(
         "--memory-limit", arguments->memory_limit,
         "Memory for the hierarchy, such as 512M (default: a quarter of the machine's); "
         "with a focus or a budget also for what is made of it; --max-distance and --simplify "
         "go piece by piece where all at once would be beyond it, which takes about as much again "
         "beside it")
      ->type_name("BYTES");
  app->add_flag(
      "--salvage", arguments->reading.salvage,
      "Use what is whole of a damaged or cut-off .lode file: what is lost is filled from coarser "
      "levels, within a bound that is reported");
  add_extraction_options(*app, arguments->extraction);
  add_simplify_options(*app, arguments->simplify);
  add_query_options(*app, arguments->query);
  add_terrain_focus_options(*app, arguments->focus);
  add_raster_options(*app, arguments->raster);
  add_progressive_option(*app, arguments->progressive,
                         "Also write the surface from coarse to fine, step-000 and so on with "
                         "index.json, to a new or empty directory");
  add_reading_options(*app, arguments->reading);
  add_terrain_options(*app, arguments->terrain, TerrainUse::extraction);
  add_to_crs(*app, arguments->terrain,
             "Write a terrain's mesh with x and y in this CRS, through PROJ; its error is measured "
             "there again. --clip, --box, --focus-point and --view stay in the CRS of the file");
  return {app, [arguments, app] { return check_extract(*arguments, *app); },
          [arguments](Session& session) { return run_extract(*arguments, session); }, kFooter};
}

}  // namespace lode::cli
