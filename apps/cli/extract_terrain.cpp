#include "extract_terrain.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>

#include "build_terrain.h"
#include "lode/api/picture_frame.h"
#include "outputs.h"
#include "parse.h"
#include "stopwatch.h"
#include "terrain_answer.h"
#include "terrain_clip.h"
#include "terrain_facts.h"
#include "terrain_query.h"
#include "to_crs.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

/// What a job asks for, but for the metric of its focus.
struct Wanted {
  TerrainOptions options;
  std::optional<TerrainBuildOptions> building;  ///< Of a raster.
  bool has_shares = false;  ///< Tolerances are of the range of heights, until it is known.
};

/// Levels are built for both.
Result<bool> has_shares(const TerrainJob& job, const TerrainOptions& options) {
  const std::string& outside = job.query.max_error_outside;
  const bool is_mixed =
      !job.max_error.empty() && !outside.empty() && is_share(job.max_error) != is_share(outside);
  if (!is_mixed) return is_share(job.max_error) || is_share(outside);
  // Of 0 it does not matter.
  if (options.max_error == 0.0) return is_share(outside);
  if (options.focus && options.focus->max_error_outside == 0.0) return is_share(job.max_error);
  return fail("--max-error-outside: expected % of the range as in --max-error, or none, got '{}'",
              outside);
}

Result<Wanted> to_wanted(const TerrainJob& job) {
  Wanted wanted;
  LODE_TRY(wanted.options, to_terrain_options(job.max_error, job.query.max_cells, job.terrain));
  LODE_TRY(wanted.options.focus, to_terrain_focus(job.query, job.focus, job.max_error));
  LODE_TRY(wanted.has_shares, has_shares(job, wanted.options));
  // Nothing finer is asked for; a number of triangles may take all samples.
  std::optional<double> finest = wanted.options.max_error;
  if (!finest && wanted.options.max_cells) finest = 0;
  // Pixels may take any tolerance.
  const bool by_pixels = wanted.options.focus && wanted.options.focus->view &&
                         wanted.options.focus->view->max_error_px;
  if (by_pixels) finest = 0;
  if (finest && wanted.options.focus && wanted.options.focus->max_error_outside)
    finest = std::min(*finest, *wanted.options.focus->max_error_outside);
  LODE_TRY(wanted.building, to_build_options(job.terrain, finest));
  if (wanted.building && (wanted.options.max_cells || wanted.options.focus))
    choose_levels(by_pixels || wanted.options.max_cells ? wanted.options.max_error : finest,
                  *wanted.building);
  return wanted;
}

/// How the terrain was made into what is written, and what that took.
struct Written {
  TerrainReport report;
  std::optional<TerrainRasterReport> raster{};
  double seconds = 0;
  std::optional<TerrainClip> clip{};
  std::optional<MappedAnswer> mapped{};
};

bool names_output(const Error& error, const TerrainJob& job) {
  return error.message.starts_with(job.output + ": ") ||
         (!job.raster.difference.empty() &&
          error.message.starts_with(job.raster.difference + ": "));
}

bool is_gltf_path(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".glb";
}

/// Metres of a unit of x, y and heights, for formats that are in metres.
Vec3d metres_of_axes(const TerrainJob& job, const HeightFrame& frame, const HeightRange& range,
                     Session& session) {
  if (!is_gltf_path(job.output)) return {{1, 1, 1}};
  const Result<HorizontalMetric> metric = read_metric(frame.crs);
  const auto place = metric ? picture_frame(frame, range, *metric, 1.0) : metric.error();
  if (!place) {
    session.warn(fmt::format("{}: its coordinates are taken for metres, as those of glTF are: {}",
                             job.output, place.error().message));
    return {{1, 1, 1}};
  }
  if (!metric->is_known)
    session.warn(
        fmt::format("{}: x and y are taken for metres, as those of glTF are: the CRS is not known",
                    job.output));
  warn_of_unit(place->is_vertical_unit_known, frame, *metric, job.input, session);
  return {{place->x_scale, place->y_scale, place->z_scale}};
}

/// A surface, and where and in which CRS it is.
struct MadeTerrain {
  TerrainSurface terrain;
  HeightFrame frame;
  std::optional<MappedAnswer> mapped{};
};

Result<MadeTerrain> make_mapped(const TerrainJob& job, const OpenedTerrain& opened,
                                const TerrainOptions& options, const std::optional<PlaceBox>& clip,
                                Session& session) {
  const HeightFrame& frame = opened.facts.frame;
  LODE_TRY(auto target, open_to_crs(job.input, job.terrain, frame, session));
  LODE_TRY(MappedTerrain made, naming(job.input,
                                      extract_mapped_terrain(opened.terrain, options,
                                                             {.map = *target->map,
                                                              .name = target->name,
                                                              .clip = clip,
                                                              .samples = measured_samples(opened)},
                                                             session.progress()),
                                      session));
  HeightFrame round = frame_round(made.terrain, frame, target->crs);
  return MadeTerrain{std::move(made.terrain), std::move(round),
                     MappedAnswer{*std::move(target), made.errors, made.measured_at, made.seconds}};
}

Result<MadeTerrain> make_surface(const TerrainJob& job, const OpenedTerrain& opened,
                                 const TerrainOptions& options, Session& session) {
  const HeightFrame& frame = opened.facts.frame;
  LODE_TRY(auto clip, to_terrain_clip(job.clip, job.output));
  if (clip) {
    LODE_TRY(const HorizontalMetric metric, naming(job.input, read_metric(frame.crs), session));
    clip = near_terrain(*clip, metric, frame);
  }
  if (!job.terrain.to_crs.empty()) return make_mapped(job, opened, options, clip, session);
  LODE_TRY(TerrainSurface made,
           naming(job.input, extract_terrain(opened.terrain, options, session.progress(), clip),
                  session));
  return MadeTerrain{std::move(made), frame};
}

Result<Written> write_tin(const TerrainJob& job, const OpenedTerrain& opened,
                          const TerrainOptions& options, Session& session) {
  if (is_geotiff_path(job.output)) {
    LODE_TRY(TerrainRasterOptions wanted, to_raster_options(job.raster));
    wanted.threads = session.threads();
    LODE_CHECK(read_samples(job.raster, opened, wanted, session));
    wanted.comment = [&](const TerrainReport& report) {
      return summary_of(report, opened, options.order);
    };
    auto written = write_terrain_raster(opened, options, wanted, job.output, session.progress());
    // What cannot be written is named already.
    const bool is_named = !written && names_output(written.error(), job);
    LODE_TRY(const TerrainRasterReport made,
             is_named ? std::move(written) : naming(job.input, std::move(written), session));
    return Written{made.terrain, made, made.sample_seconds + made.write_seconds};
  }
  LODE_TRY(const MadeTerrain surface, make_surface(job, opened, options, session));
  const TerrainSurface& made = surface.terrain;
  const Stopwatch watch;
  LODE_CHECK(
      write_surface(job.output, made.surface,
                    {.comment = comment_of(made.report, opened, options.order, surface.mapped),
                     .value_name = "height",
                     .node_name = "terrain",
                     .metres = metres_of_axes(job, surface.frame, opened.terrain.range(), session),
                     .places = made.places,
                     .threads = session.threads()},
                    session.progress()));
  TerrainReport report = made.report;
  if (!made.places.empty() && can_hold_places(job.output)) {
    report.height_slack = report.position_slack = 0;
    report.n_turned = 0;  // by floats, which the file has none of
  }
  return Written{report, {}, watch.seconds(), made.clip, surface.mapped};
}

}  // namespace

Result<TerrainOptions> to_terrain_options(const std::string& max_error,
                                          const std::string& max_cells,
                                          const TerrainArguments& terrain) {
  TerrainOptions options;
  LODE_TRY(options.max_error, to_max_error(max_error));
  if (!max_cells.empty()) {
    constexpr std::int64_t kMaxCells = std::int64_t{1} << 30;
    LODE_TRY(const auto n, parse_integer("--max-cells", max_cells, 1, kMaxCells));
    options.max_cells = static_cast<std::uint64_t>(n);
  }
  const std::string& insertion = terrain.insertion;
  if (!insertion.empty()) {
    LODE_TRY(options.order, to_insertion_order(insertion));
  }
  if (!insertion.empty() && insertion != "strict" && options.max_cells)
    return fail("--insertion: expected 'strict' with --max-cells, got '{}'", insertion);
  return options;
}

namespace {

Result<void> check_wrap(const TerrainJob& job) {
  if (!job.terrain.wrap) return {};
  if (is_geotiff_path(job.output))
    return fail("--wrap: expected a surface as output, got {}: rasters have no sides to close",
                job.output);
  if (job.query.max_cells.empty() || !job.terrain.model.empty()) return {};
  return fail(
      "--wrap: expected no --max-cells with it, which would need the tolerance before: both sides "
      "get their vertices first, within --max-error");
}

}  // namespace

Result<void> check_terrain_job(const TerrainJob& job, const CLI::App& app) {
  LODE_CHECK(check_only_terrain(
      app, job.input,
      {"--max-error", "--max-cells", "--model", "--insertion", "--box", "--focus-point", "--growth",
       "--view", "--view-size", "--max-error-px", "--exaggeration", "--max-error-outside", "--cell",
       "--difference", "--against", "--clip", "--to-crs"}));
  LODE_CHECK(check_terrain_model(job.input, job.terrain, job.reading));
  if (!is_geotiff_path(job.output)) LODE_CHECK(check_terrain_surface(job.output));
  LODE_CHECK(check_raster_arguments(job.raster, job.input, job.output));
  LODE_CHECK(check_wrap(job));
  LODE_CHECK(check_to_crs(job.terrain));
  LODE_CHECK(check_to_crs_output(job.terrain, job.output));
  if (!job.terrain.to_crs.empty() && is_geotiff_path(job.output))
    return fail(
        "--to-crs: expected a surface (.ply, .obj, .glb, .vtp) as output, got {}: a raster "
        "in "
        "another CRS has other samples, which gdalwarp makes",
        job.output);
  if (auto clip = to_terrain_clip(job.clip, job.output); !clip) return clip.error();
  LODE_TRY(const Wanted wanted, to_wanted(job));
  const bool can_vary = wanted.building || holds_terrain_model(job.input);
  if (wanted.options.focus && !can_vary)
    return fail(
        "{}: expected one tolerance for all of a terrain, got a focus: --model delaunay_pyramid "
        "can vary, of rasters right_triangle_bisection and others too, and so can a .lode file "
        "that `lode build` makes",
        job.input);
  if (wanted.options.focus && wanted.options.max_cells)
    return fail(
        "--max-cells: expected no --box, --focus-point or --view with it: these say which "
        "tolerances hold where, and a number of triangles is met by one tolerance for all of the "
        "terrain");
  LODE_CHECK(check_terrain_reading(job.input, job.terrain, job.reading));
  std::vector<std::string> outputs{job.output};
  if (!job.raster.difference.empty()) outputs.push_back(job.raster.difference);
  std::vector<std::string> inputs{job.input};
  for (const std::string* const path : {&job.query.view, &job.raster.against})
    if (!path->empty()) inputs.push_back(*path);
  return check_paths_differ(inputs, outputs);
}

Result<Outcome> run_terrain_job(const TerrainJob& job, Session& session) {
  LODE_TRY(Wanted wanted, to_wanted(job));
  TerrainOptions& options = wanted.options;
  options.threads = session.threads();
  const bool has_view = options.focus && options.focus->view;
  if (has_view) {
    LODE_TRY(options.focus->view->view, read_view(job.query));
  }
  LODE_CHECK(check_writable(job.output));
  if (!job.raster.difference.empty()) LODE_CHECK(check_writable(job.raster.difference));
  const Stopwatch read_watch;
  LODE_TRY(
      const OpenedTerrain opened,
      open_terrain(job.input, job.terrain, job.reading, wanted.building, options.max_error, session,
                   {.keeps_samples = !job.raster.difference.empty() || !job.terrain.to_crs.empty(),
                    .has_shares = wanted.has_shares}));
  const HeightRange range = opened.terrain.range();
  set_share(job.max_error, range, options.max_error);
  options.is_closed = opened.is_closed;
  if (options.focus)
    set_share(job.query.max_error_outside, range, options.focus->max_error_outside);
  if (has_view) LODE_CHECK(check_upwards(opened.facts.frame, job.input));
  if (options.focus) {
    LODE_TRY(options.focus->metric,
             naming(job.input, read_metric(opened.facts.frame.crs), session));
  }
  const double read_seconds = read_watch.seconds();
  if (!is_geotiff_path(job.output) && job.terrain.to_crs.empty())
    hint_at_wrap(opened, job.input, session);
  OutputSet outputs({job.output, job.raster.difference});
  if (!job.raster.difference.empty()) outputs.add(job.raster.difference);
  LODE_TRY(const Written made, write_tin(job, opened, options, session));
  outputs.keep();
  const TerrainReport& report = made.report;
  warn_of(report, opened, job, options.focus, made.clip, session);
  if (made.mapped) warn_of_mapped(*made.mapped, report, session);
  const bool is_strict = options.max_cells || opened.built.has_value();
  const TerrainAnswer answer{job,
                             opened,
                             options,
                             report,
                             is_strict ? InsertionOrder::strict : options.order,
                             read_seconds,
                             made.seconds,
                             made.raster,
                             made.clip,
                             made.mapped};
  Table table;
  Outcome outcome;
  outcome.json = answer_json(answer, table, session);
  add_rows(answer, table);
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace lode::cli
