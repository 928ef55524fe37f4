#include "verify_terrain.h"

#include "lode/api/mapped_verification.h"
#include "terrain_query.h"
#include "to_crs.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

Result<void> check_model_verify(const TerrainVerifyJob& job, const CLI::App& app) {
  if (!job.surface.empty())
    return fail(
        "{}: expected the raster or points that it was built of with --surface, as in lode verify "
        "dem.tif --surface {}, got a .lode file",
        job.input, job.surface);
  LODE_CHECK(check_only_terrain(app, job.input, {"--against"}));
  if (!job.original.empty() && !is_terrain_path(job.original))
    return fail("--against: expected the raster or points that {} was built of, got {}", job.input,
                job.original);
  if (job.original.empty() && !job.terrain.is_empty())
    return fail("{}: expected --against with options of reading, got none", job.input);
  if (job.original.empty()) return {};
  return check_terrain_reading(job.original, job.terrain, job.reading);
}

Result<TinShape> to_shape(const TerrainArguments& terrain) {
  const std::string& model = terrain.model;
  auto order = InsertionOrder::levels;
  if (!terrain.insertion.empty()) {
    LODE_TRY(order, to_insertion_order(terrain.insertion));
  }
  if (model.empty() || model == name_of(TerrainModel::delaunay_selector))
    return order == InsertionOrder::tiles ? TinShape::tiles : TinShape::delaunay;
  if (order == InsertionOrder::tiles)
    return fail("--insertion: expected none with --model {}, got 'tiles'", model);
  LODE_TRY(const TerrainModel built, to_built_model(model));
  if (has_gaps(built))
    return fail("--model: expected a model without gaps, got '{}', whose files verify checks",
                model);
  if (is_hierarchy(built))
    return fail(
        "--model: expected a model whose vertices are samples, got '{}', whose files verify "
        "checks",
        model);
  return shape_of(built);
}

/// A raster without its lines, but wrapped.
Result<OpenedTerrain> open_raster(const std::string& path, const TerrainVerifyJob& job,
                                  Session& session) {
  return open_terrain(path, job.terrain.without_lines(), job.reading, {}, {}, session,
                      {.keeps_samples = !job.terrain.to_crs.empty()});
}

/// Against the raster or points that it was built of.
Result<VerifyReport> verify_origin(const TerrainVerifyJob& job, const BuiltTerrain& built,
                                   Session& session) {
  const bool is_of_points = built.describe_source().is_of_points;
  if (is_point_path(job.original) || (is_of_points && job.terrain.has_lines())) {
    LODE_TRY(const OpenedTerrain opened,
             open_terrain(job.original, job.terrain, job.reading, {}, {}, session));
    return naming(job.original, built.verify(*opened.points, session.threads(), session.progress()),
                  session);
  }
  LODE_TRY(const OpenedTerrain raster, open_raster(job.original, job, session));
  LODE_TRY(VerifyReport report,
           naming(job.original, built.verify(*raster.grid, session.threads(), session.progress()),
                  session));
  if (!is_hierarchy(built.model()) || !job.terrain.has_lines()) return report;
  LODE_TRY(const OpenedTerrain lined,
           open_terrain(job.original, job.terrain, job.reading, {}, {}, session));
  LODE_TRY(const VerifyReport lines,
           naming(job.original, built.verify(*lined.points, session.threads(), session.progress()),
                  session));
  report.checks.insert(report.checks.end(), lines.checks.begin(), lines.checks.end());
  return report;
}

/// Every byte, then all that it says against its origin.
Result<VerifyReport> verify_model(const TerrainVerifyJob& job, Session& session) {
  LODE_TRY(VerifyReport report,
           verify_every_byte(job.input, session.threads(), session.progress()));
  if (!report.passed()) return report;
  LODE_TRY(const BuiltTerrain built, BuiltTerrain::open(job.input, session.progress()));
  // Models on squares have all heights: what they can be held against is no more than the raster.
  if (job.original.empty() || !is_on_squares(built.model())) {
    LODE_TRY(const VerifyReport alone, built.verify_alone(session.threads(), session.progress()));
    report.checks.insert(report.checks.end(), alone.checks.begin(), alone.checks.end());
  }
  if (job.original.empty()) return report;
  LODE_TRY(const VerifyReport against, verify_origin(job, built, session));
  report.checks.insert(report.checks.end(), against.checks.begin(), against.checks.end());
  return report;
}

/// In the terrain's CRS, or in that of --to-crs.
Result<VerifyReport> verify_surface(const TerrainVerifyJob& job, const OpenedTerrain& opened,
                                    const TerrainVerifyOptions& wanted, Session& session) {
  LODE_TRY(const PlacedSurface placed, read_placed_surface(job.surface));
  TerrainVerifyOptions options = wanted;
  LODE_TRY(options.shape, to_shape(job.terrain));
  options.threads = session.threads();
  if (!job.terrain.to_crs.empty()) {
    LODE_TRY(const auto target, open_to_crs(job.input, job.terrain, opened.facts.frame, session));
    LODE_TRY(const auto source, open_from_crs(job.input, job.terrain, opened.facts.frame));
    return verify_mapped_terrain(opened, placed, options,
                                 {.there = *target->map, .back = *source.map, .name = target->name},
                                 session.progress());
  }
  options.places = placed.places;
  return opened.points ? verify_terrain(*opened.points, placed.surface, options, session.progress())
                       : verify_terrain(*opened.grid, placed.surface, options, session.progress());
}

}  // namespace

Result<void> check_terrain_verify(const TerrainVerifyJob& job, const CLI::App& app) {
  if (!job.terrain.resample.empty() || !job.terrain.oversample.empty())
    return fail("--resample: expected a folder of tiles with it, got {}", job.input);
  if (holds_terrain_model(job.input)) return check_model_verify(job, app);
  LODE_CHECK(check_only_terrain(
      app, job.input, {"--surface", "--max-error", "--model", "--insertion", "--to-crs"}));
  LODE_CHECK(check_to_crs(job.terrain));
  LODE_CHECK(check_to_crs_output(job.terrain, job.surface));
  if (job.surface.empty())
    return fail("{}: expected --surface FILE to hold against this terrain, got none", job.input);
  LODE_CHECK(check_surface_path(job.surface));
  if (job.max_error.empty())
    return fail("--surface: expected the --max-error it was extracted with, got none");
  if (auto max_error = to_max_error(job.max_error); !max_error) return max_error.error();
  if (auto shape = to_shape(job.terrain); !shape) return shape.error();
  LODE_CHECK(check_insertion(job.input, job.terrain));
  const auto model = built_model_of(job.terrain.model);
  if (job.terrain.has_lines() && model && !is_of_any_points(*model))
    return fail(
        "{}: expected a model that keeps lines with them, got '{}', whose files verify checks",
        job.input, job.terrain.model);
  LODE_CHECK(check_model_of_points(job.input, job.terrain));
  return check_terrain_reading(job.input, job.terrain, job.reading);
}

Result<VerifyReport> verify_terrain_input(const TerrainVerifyJob& job, Session& session) {
  if (holds_terrain_model(job.input)) return verify_model(job, session);
  LODE_TRY(std::optional<double> max_error, to_max_error(job.max_error));
  const bool is_of_points = is_point_path(job.input) || job.terrain.has_lines();
  LODE_TRY(const OpenedTerrain opened,
           is_of_points ? open_terrain(job.input, job.terrain, job.reading, {}, max_error, session,
                                       {.has_shares = is_share(job.max_error)})
                        : open_raster(job.input, job, session));
  set_share(job.max_error, opened.terrain.range(), max_error);
  const bool matches_sides = !is_of_points && !built_model_of(job.terrain.model);
  return verify_surface(
      job, opened, {.max_error = max_error.value_or(0), .matches_sides = matches_sides}, session);
}

Result<void> check_tile_verify(const TerrainVerifyJob& job, const CLI::App& app) {
  LODE_CHECK(check_only_terrain(app, job.input, {"--against"}));
  if (!job.original.empty() && !is_height_path(job.original))
    return fail("--against: expected the raster that {} was made of, got {}", job.input,
                job.original);
  if (job.original.empty() && !job.terrain.is_empty())
    return fail("{}: expected --against with options of rasters, got none", job.input);
  if (auto options = to_height_options(job.terrain, job.reading); !options) return options.error();
  return {};
}

Result<VerifyReport> verify_tile_folder(const TerrainVerifyJob& job, Session& session) {
  TileVerifyOptions options{.original = job.original, .threads = session.threads()};
  LODE_TRY(options.reading, to_height_options(job.terrain, job.reading));
  LODE_TRY(TileVerification verified, verify_tiles(job.input, options, session.progress()));
  warn_of_vertical(verified.vertical, job.original, session);
  return std::move(verified.report);
}

}  // namespace lode::cli
