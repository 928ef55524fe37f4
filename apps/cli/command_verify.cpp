#include <fmt/format.h>

#include <iterator>
#include <memory>

#include "command.h"
#include "extraction_options.h"
#include "input.h"
#include "parse.h"
#include "query_options.h"
#include "simplify_options.h"
#include "stopwatch.h"
#include "text.h"
#include "to_crs.h"
#include "tolerance.h"
#include "verify_terrain.h"
#include "verify_tetra.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

struct VerifyArguments {
  std::string input;
  std::string original;
  std::vector<std::string> surfaces;
  std::string memory_limit;
  std::string error_bound;
  std::vector<std::string> boxes;
  bool is_exact = false;
  SimplifyArguments simplify;
  ExtractionArguments extraction;
  ReadingArguments reading;
  TerrainArguments terrain;

  /// The first; empty where there is none.
  [[nodiscard]] std::string surface() const { return surfaces.empty() ? "" : surfaces.front(); }
};

Result<ExtractOptions> options_of(const VerifyArguments& arguments) {
  LODE_TRY(ExtractOptions options, to_extract_options(arguments.extraction));
  LODE_CHECK(apply_simplify_options(arguments.simplify, options));
  if (!arguments.memory_limit.empty()) {
    if (!options.max_distance && !arguments.surfaces.empty())
      return fail(
          "--memory-limit: expected --max-distance, without --simplify, where there is a "
          "--surface: no other is extracted again with it");
    LODE_TRY(options.memory_limit, parse_bytes("--memory-limit", arguments.memory_limit));
  }
  return options;
}

/// Of --error-bound; its boxes alone are looked at here.
Result<BoundOptions> bound_of(const VerifyArguments& arguments, const DatasetInfo& info,
                              Threads threads) {
  BoundOptions options{.threads = threads};
  LODE_TRY(const ExtractOptions extraction, to_extract_options(arguments.extraction));
  options.isovalue = extraction.isovalues.front();
  LODE_TRY(options.error, parse_tolerance("--error-bound", arguments.error_bound));
  std::optional<double> error = options.error;
  set_share(arguments.error_bound, info.range_min, info.range_max, error);
  options.error = *error;
  LODE_TRY(options.boxes, parse_boxes(arguments.boxes));
  return options;
}

/// That a bound is asked of one surface and isovalue, and nothing of how it was made.
Result<void> check_bound(const VerifyArguments& arguments, const CLI::App& app) {
  if (arguments.error_bound.empty())
    return arguments.boxes.empty() ? Result<void>()
                                   : fail("--box: expected --error-bound with it, got none");
  if (arguments.surfaces.size() != 1 || arguments.extraction.isovalues.size() != 1)
    return fail("--error-bound: expected one --surface and one --isovalue with it, got {} and {}",
                arguments.surfaces.size(), arguments.extraction.isovalues.size());
  for (const char* name :
       {"--max-error", "--style", "--style-distance", "--keep-topology", "--clip", "--close-border",
        "--min-component", "--flip", "--normals", "--simplify", "--max-distance", "--memory-limit"})
    if (app.get_option(name)->count() > 0)
      return fail(
          "--error-bound: expected nothing else of how the surface was made, got {}{}", name,
          std::string_view(name) == "--clip" ? ": a --box a little smaller holds what was cropped"
                                             : "");
  LODE_CHECK(parse_tolerance("--error-bound", arguments.error_bound));
  LODE_CHECK(parse_boxes(arguments.boxes));
  return {};
}

/// For looking at the file; a surface's limit says how that was extracted. 0: none was given.
std::uint64_t limit_of_file(const VerifyArguments& arguments, const ExtractOptions& options) {
  return arguments.surfaces.empty() ? options.memory_limit : 0;
}

[[nodiscard]] TetraVerifyJob tetra_job(const VerifyArguments& arguments) {
  return {arguments.input, arguments.original, arguments.is_exact, arguments.reading};
}

[[nodiscard]] TerrainVerifyJob terrain_job(const VerifyArguments& arguments) {
  return {arguments.input,     arguments.original,
          arguments.surface(), arguments.extraction.max_error,
          arguments.terrain,   arguments.reading};
}

/// They say how a surface was extracted: without one they would mean nothing.
Result<void> check_no_surface_options(const CLI::App& app) {
  for (const char* name :
       {"--isovalue", "--max-error", "--style", "--style-distance", "--keep-topology", "--clip",
        "--close-border", "--min-component", "--flip", "--normals", "--simplify"})
    if (app.get_option(name)->count() > 0)
      return fail("{}: expected --surface FILE with it, got none", name);
  return {};
}

Result<void> check_verify(const VerifyArguments& arguments, const CLI::App& app) {
  if (arguments.surfaces.size() > 1 &&
      (holds_tiles(arguments.input) || holds_terrain(arguments.input)))
    return fail("--surface: expected one for terrain, got {}", arguments.surfaces.size());
  if (holds_tiles(arguments.input)) return check_tile_verify(terrain_job(arguments), app);
  if (holds_terrain(arguments.input)) return check_terrain_verify(terrain_job(arguments), app);
  if (const auto none = check_no_terrain(arguments.terrain, arguments.input); !none) {
    // A file that is not there is of no model either.
    if (is_lode_path(arguments.input)) LODE_CHECK(check_lode_opens(arguments.input));
    return none.error();
  }
  if (holds_cells(arguments.input)) {
    if (!arguments.surfaces.empty())
      return fail("--surface: expected a volume or its .lode file with it, got the mesh '{}'",
                  arguments.input);
    if (!arguments.memory_limit.empty())
      return fail("--memory-limit: expected a volume's .lode file with it, got the mesh '{}'",
                  arguments.input);
    return check_tetra_verify(tetra_job(arguments));
  }
  if (arguments.is_exact)
    return fail("--exact: expected a mesh of cells or its .lode file with it, got '{}'",
                arguments.input);
  LODE_CHECK(check_bound(arguments, app));
  LODE_TRY(const ExtractOptions options, options_of(arguments));
  if ((options.max_distance || options.simplify_distance) && arguments.surfaces.empty())
    return fail("{}: expected --surface FILE with it, got none",
                options.simplify_distance ? "--simplify" : "--max-distance");
  if (!arguments.surfaces.empty()) {
    for (const std::string& path : arguments.surfaces) LODE_CHECK(check_surface_path(path));
    if (options.isovalues.empty())
      return fail("--surface: expected the --isovalue it was extracted with, got none");
    if (arguments.surfaces.size() > 1 && arguments.surfaces.size() != options.isovalues.size())
      return fail("--surface: expected an --isovalue for each of {} surfaces, got {}",
                  arguments.surfaces.size(), options.isovalues.size());
  } else {
    LODE_CHECK(check_no_surface_options(app));
  }
  if (!arguments.original.empty()) {
    if (is_lode_path(arguments.original))
      return fail("--against: expected the original data, got the .lode file '{}'",
                  arguments.original);
    if (auto reading = to_read_options(arguments.reading, {}); !reading) return reading.error();
    return {};
  }
  if (!is_lode_path(arguments.input) && arguments.surfaces.empty())
    return fail("{}: expected a .lode file, or --surface FILE to check against this volume",
                arguments.input);
  return check_reading_options(arguments.reading, arguments.input);
}

void append(VerifyReport& report, VerifyReport more) {
  report.checks.insert(report.checks.end(), std::make_move_iterator(more.checks.begin()),
                       std::make_move_iterator(more.checks.end()));
}

/// Files of several isovalues are of one surface, or, where each was extracted by itself, of one
/// each.
Result<VerifyReport> verify_surfaces(const std::vector<std::string>& paths, const Dataset& dataset,
                                     const ExtractOptions& options, Session& session) {
  Progress& progress = session.progress();
  if (paths.size() == 1 || dataset.takes_several_isovalues(options)) {
    LODE_TRY(const Surface surface, paths.size() == 1
                                        ? read_surface(paths.front())
                                        : read_isovalue_files(paths, options.isovalues));
    return dataset.verify_surface(surface, options, progress);
  }
  VerifyReport report;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    ExtractOptions alone = options;
    alone.isovalues = {options.isovalues[i]};
    LODE_TRY(const Surface surface, read_surface(paths[i]));
    LODE_TRY(VerifyReport one, dataset.verify_surface(surface, alone, progress));
    for (VerifyReport::Check& check : one.checks)
      check.name = fmt::format("{}: {}", options.isovalues[i], check.name);
    append(report, std::move(one));
  }
  return report;
}

Result<void> verify_model(const VerifyArguments& arguments, Session& session,
                          VerifyReport& report) {
  LODE_TRY(const ExtractOptions asked, options_of(arguments));
  // Within a distance the query is repeated as it was made, by chunks where that is how, before the
  // model is loaded; without a surface it may never be.
  const auto get = asked.max_distance || arguments.surfaces.empty() ? open_input : load_input;
  LODE_TRY(const Input input, get(session, arguments.input, arguments.reading, {}));
  VerifyReport of_surface;
  if (!arguments.error_bound.empty()) {
    LODE_TRY(const BoundOptions bound, bound_of(arguments, input.info, session.threads()));
    warn_of_boxes(bound.boxes, input.info.volume.grid.world_bounds(), session);
    LODE_TRY(const Surface surface, read_surface(arguments.surface()));
    LODE_TRY(of_surface, input.dataset.verify_bound(surface, bound, session.progress()));
  } else if (!arguments.surfaces.empty()) {
    ExtractOptions options = asked;
    set_share(arguments.extraction.max_error, input.info.range_min, input.info.range_max,
              options.max_error);
    set_share(arguments.extraction.keep_topology, input.info.range_min, input.info.range_max,
              options.keep_topology);
    options.threads = session.threads();
    LODE_TRY(of_surface, verify_surfaces(arguments.surfaces, input.dataset, options, session));
  }
  if (!arguments.original.empty()) {
    LODE_TRY(const ReadOptions options, to_read_options(arguments.reading, session.threads()));
    LODE_TRY(const auto original, open_foreign_volume(arguments.original, options));
    LODE_TRY(VerifyReport more,
             input.dataset.verify_against(*original, session.threads(), session.progress(),
                                          limit_of_file(arguments, asked)));
    append(report, std::move(more));
  }
  append(report, std::move(of_surface));
  return {};
}

Outcome report_checks(const VerifyArguments& arguments, const VerifyReport& report,
                      double seconds) {
  Outcome outcome;
  outcome.exit_code = report.passed() ? 0 : 1;
  Json checks = Json::array();
  Table table({"check", "count", "result", "detail"});
  for (const VerifyReport::Check& check : report.checks) {
    Json& json = checks.emplace_back();
    json["name"] = check.name;
    json["count"] = check.count;
    json["passed"] = check.skipped ? Json(nullptr) : Json(check.passed);
    json["detail"] = check.detail;
    table.add({check.name, format_count(check.count),
               check.skipped  ? "skipped"
               : check.passed ? "passed"
                              : "FAILED",
               check.detail});
  }
  const auto or_null = [](const std::string& path) {
    return path.empty() ? Json(nullptr) : Json(path);
  };
  outcome.json["command"] = "verify";
  outcome.json["file"] = arguments.input;
  outcome.json["against"] = or_null(arguments.original);
  outcome.json["surface"] =
      arguments.surfaces.size() > 1 ? Json(arguments.surfaces) : or_null(arguments.surface());
  outcome.json["passed"] = report.passed();
  outcome.json["checks"] = std::move(checks);
  outcome.json["seconds"] = seconds;
  outcome.text = table.to_string();
  return outcome;
}

Result<Outcome> run_verify(const VerifyArguments& arguments, Session& session) {
  const Stopwatch watch;
  VerifyReport report;
  const bool needs_model = !arguments.original.empty() || !arguments.surfaces.empty();
  const bool is_of_tiles = holds_tiles(arguments.input);
  const bool is_terrain = is_of_tiles || holds_terrain(arguments.input);
  const bool is_tetra = !is_terrain && holds_cells(arguments.input);
  if (is_of_tiles) {
    LODE_TRY(report, verify_tile_folder(terrain_job(arguments), session));
  } else if (is_terrain) {
    LODE_TRY(report, verify_terrain_input(terrain_job(arguments), session));
  } else if (is_tetra) {
    LODE_TRY(report, verify_tetra(tetra_job(arguments), session));
  } else if (is_lode_path(arguments.input)) {
    LODE_TRY(const ExtractOptions options, options_of(arguments));
    LODE_TRY(report, verify_file(arguments.input, session.threads(), session.progress(),
                                 limit_of_file(arguments, options)));
  }
  if (!is_tetra && !is_terrain && needs_model && report.passed())
    LODE_CHECK(verify_model(arguments, session, report));
  for (const VerifyReport::Check& check : report.checks)
    if (check.skipped)
      session.warn(fmt::format("{}: {}: {}", arguments.input, check.name, check.detail));
  for (const VerifyReport::Check& check : report.checks) {
    if (check.passed) continue;
    session.fail(fmt::format("{}: failed: {}{}{}",
                             arguments.surfaces.empty() ? arguments.input : arguments.surface(),
                             check.name, check.detail.empty() ? "" : ": ", check.detail));
    break;
  }
  return report_checks(arguments, report, watch.seconds());
}

/// Of volumes, meshes and terrain.
constexpr HelpFooter kVerifyFooter{{{
    {"Reads and checks every byte of FILE, and finds errors anew from its samples.\n"
     "--against compares these with the original data, and finds errors by their definition,\n"
     "which takes a minute or two for 16 million samples.\n"
     "--surface checks a surface, given the options it was extracted with.\n",
     "  lode verify scan.lode --against scan.nrrd\n"
     "  lode verify scan.lode --surface bone.ply --isovalue 1200 --max-error 10\n"
     "  lode verify scan.lode --surface bone.ply --isovalue 1200 --max-distance 0.5\n"
     "  lode verify scan.lode --surface bone-300.stl --surface bone-1200.stl --isovalue 300 "
     "--isovalue 1200 --keep-topology\n"
     "  lode verify scan.lode --surface bone.ply --isovalue 1200 --simplify --max-error 10\n"
     "  lode verify scan.lode --surface bone.ply --isovalue 1200 --simplify --max-distance 0.5\n"
     "  lode verify scan.lode --surface near.ply --isovalue 1200 --error-bound 10 --box "
     "0,9,0,9,0,9\n"},
    {"Of meshes of cells, or .lode files made from them: nodes and their order, random cuts, and\n"
     "all stated errors and ranges; --against compares every vertex, value and cell.\n",
     "  lode verify mesh.vtu\n"
     "  lode verify mesh.lode --against mesh.vtu\n"},
    {"Of terrain --surface is a TIN: Delaunay, of samples, and within --max-error.\n"
     "Of .lode files made of rasters --against looks at every level and every triangle's error.\n\n"
     "Of a folder of tiles: that each covers its square, that they meet, and with --against that\n"
     "every sample is within the error that layer.json states of each level.\n",
     "  lode verify dem.tif --surface dem.ply --max-error 10\n"
     "  lode verify dem.lode --against dem.tif\n"
     "  lode verify tiles --against dem.tif\n"},
}}};

}  // namespace

Command add_verify_command(CLI::App& program) {
  auto arguments = std::make_shared<VerifyArguments>();
  CLI::App* app =
      program.add_subcommand("verify", "Check a .lode file, a mesh's hierarchy, or a surface");
  app->add_option("file", arguments->input, ".lode file, or a volume or mesh to build in memory")
      ->type_name("FILE")
      ->required();
  app->add_option("--against,--original", arguments->original, "Original data of FILE")
      ->type_name("ORIGINAL");
  app->add_flag("--exact", arguments->is_exact,
                "Of meshes of tetrahedra: errors at all points of random cuts, in the overlay with "
                "the mesh that was read (takes long)");
  app->add_option("--surface", arguments->surfaces,
                  "Surface to check; may be repeated for surfaces in files of their own that were "
                  "extracted together, one for each --isovalue, in the same order")
      ->type_name("SURFACE")
      ->allow_extra_args(false);
  app->add_option("--error-bound", arguments->error_bound,
                  "Hold a surface that any program may have made to this bound of |F - isovalue| "
                  "alone, or with % of the range of values, and to samples that are farther being "
                  "on their sides: one of a focus, a budget or a deadline, which no query repeats")
      ->type_name("E");
  app->add_option(
         "--box", arguments->boxes,
         "With --error-bound: only of what of the surface, and which samples, are in a box; may be "
         "repeated")
      ->type_name("X0,X1,Y0,Y1,Z0,Z1")
      ->allow_extra_args(false);
  app->add_flag(
      "--simplify,--remove-slivers", arguments->simplify.simplifies,
      "The surface was simplified: distance and pieces are held against what it was before; within "
      "--max-error alone |F - isovalue|, and the sides of samples that are farther");
  app->add_option("--max-distance", arguments->simplify.max_distance,
                  "Distance that it was extracted within, world units: measured, from full "
                  "resolution and back; with --simplify from the surface before and back")
      ->type_name("D");
  app->add_option(
         "--memory-limit", arguments->memory_limit,
         "Of a volume's FILE: it is looked at in parts as large as that allows, and with --against "
         "errors by their definition where it allows that; the report says what was left out "
         "(default: the machine's memory). Of a surface within --max-distance, as given to "
         "extract, as it has other triangles then; that takes the whole model all the same")
      ->type_name("BYTES");
  add_extraction_options(*app, arguments->extraction);
  add_reading_options(*app, arguments->reading);
  add_terrain_options(*app, arguments->terrain, TerrainUse::verification);
  add_resample_option(*app, arguments->terrain);
  add_to_crs(*app, arguments->terrain,
             "CRS that a surface of terrain was extracted to: its vertices must be where that has "
             "samples, and its errors there are measured again");
  return {app, [arguments, app] { return check_verify(*arguments, *app); },
          [arguments](Session& session) { return run_verify(*arguments, session); }, kVerifyFooter};
}

}  // namespace lode::cli
