#include "lode/api/insertions_terrain.h"

#include <algorithm>
#include <utility>

#include "lode/api/terrain_focus.h"
#include "lode/core/expects.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/tin_quality.h"
#include "lode/models/terrain/delaunay_selector/spatial_order.h"
#include "lode/models/terrain/implicit_pyramid/build.h"
#include "lode/models/terrain/insertions/build.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode {

using insertions::History;

namespace {

insertions::Model worst_first(TerrainModel model) {
  return model == TerrainModel::ternary_triangulation ? insertions::Model::ternary_triangulation
                                                      : insertions::Model::delaunay_pyramid;
}

}  // namespace

Result<History> build_insertions(const HeightGrid& grid, TerrainModel model, double max_error,
                                 Progress& progress) {
  LODE_EXPECTS(model != TerrainModel::delaunay_selector);
  if (model == TerrainModel::implicit_delaunay_pyramid)
    return implicit_pyramid::build(grid, progress);
  return insertions::build_history(grid, max_error, worst_first(model), progress);
}

Result<History> build_insertions(const PointTerrain& terrain, TerrainModel model, double max_error,
                                 Progress& progress) {
  LODE_EXPECTS(is_of_any_points(model));
  const delaunay_selector::SpatialOrder order(terrain.points, terrain.domain);
  const insertions::PointGround ground{.frame = terrain.points,
                                       .range = height_range(terrain.points),
                                       .samples = order.samples(),
                                       .triangles = order.triangles,
                                       .lines = order.lines,
                                       .n_left_out = terrain.domain.n_left_out};
  LODE_TRY(History history,
           model == TerrainModel::implicit_delaunay_pyramid
               ? implicit_pyramid::build(ground, progress)
               : insertions::build_history(ground, max_error, worst_first(model), progress));
  history.n_missing = terrain.n_missing;
  history.n_left_out += terrain.n_in_no_cell;
  return history;
}

TerrainModel InsertionsTerrain::model() const {
  switch (history().model) {
    case insertions::Model::ternary_triangulation: return TerrainModel::ternary_triangulation;
    case insertions::Model::implicit_delaunay_pyramid:
      return TerrainModel::implicit_delaunay_pyramid;
    default: return TerrainModel::delaunay_pyramid;
  }
}

Result<std::uint64_t> InsertionsTerrain::save(const std::string& path, Progress& progress) const {
  return insertions::save(levelled_, path, progress);
}

Result<SelectedTerrain> InsertionsTerrain::select(const TerrainOptions& options, delaunay::TinLinks,
                                                  Progress& progress) const {
  const Stopwatch watch;
  if (progress.is_cancelled()) return cancelled_error();
  LODE_TRY(const double tolerance, tolerance_of(options));
  SelectedTerrain selected;
  TerrainReport& report = selected.report;
  if (options.focus) {
    const auto& outside = options.focus->max_error_outside;
    if (outside && *outside < history().max_error)
      return fail(
          "expected a tolerance of {} or more outside the focus, which is what the "
          "model was built for, got {}",
          history().max_error, *outside);
    if (options.max_cells) return fail(kFocusOrCells);
    LODE_TRY(const TerrainDemand focus,
             TerrainDemand::make(*options.focus, tolerance, history().frame, history().range));
    selected.tin =
        tin_of(history(), select_nodes(history(), focus.demand()), delaunay::TinLinks::kept);
    report_focus(focus, history().frame, selected);
  } else {
    selected.tin = tin_for(options, tolerance, report);
  }
  count_selection(source(), selected);
  report.max_error = tolerance;
  report.achieved_error = largest_error(selected.tin);
  // Errors of triangles are rounded up; that of all samples is known better.
  if (report.triangles == finest_triangles())
    report.achieved_error = std::min(report.achieved_error, history().max_error);
  report.seconds = watch.seconds();
  return selected;
}

Result<SelectedTerrain> InsertionsTerrain::select_all(Progress& progress) const {
  if (history().is_worst_first()) return BuiltModel::select_all(progress);
  // All points are its vertices, and no cells say how to join them.
  if (history().is_of_points) return select({.max_error = 0}, delaunay::TinLinks::kept, progress);
  // Samples of a raster's domain are its vertices, so the same cells have four heights.
  HeightGrid grid = make_height_grid<double>(frame().n_columns, frame().n_rows);
  auto& heights = std::get<HeightGrid::Samples<double>>(grid.heights);
  grid.is_valid.assign(static_cast<std::size_t>(grid.n_samples()), 0);
  for (std::size_t v = 0; v < history().vertices.size(); ++v) {
    const auto [x, y] = history().vertices[v];
    heights[static_cast<std::size_t>(y * grid.stride + x)] = history().heights[v];
    grid.is_valid[static_cast<std::size_t>(std::int64_t{y} * grid.n_columns + x)] = 1;
  }
  return select_terrain(grid, {.max_error = 0}, delaunay::TinLinks::kept, progress);
}

std::uint64_t InsertionsTerrain::finest_triangles() const {
  return history().triangles.size() - history().removed.size();
}

Result<double> InsertionsTerrain::tolerance_of(const TerrainOptions& options) const {
  const double tolerance = default_tolerance(options, history().range);
  const double finest = history().max_error;
  if (options.max_error && tolerance < finest)
    return fail(
        "expected a tolerance of {} or more, which is what the model was built for, "
        "got {}",
        finest, tolerance);
  return options.max_cells && !options.max_error ? 0.0 : std::max(tolerance, finest);
}

delaunay::Tin InsertionsTerrain::tin_for(const TerrainOptions& options, double tolerance,
                                         TerrainReport& report) const {
  constexpr auto kLinks = delaunay::TinLinks::kept;
  report.is_within_error = history().max_error <= tolerance;
  delaunay::Tin within;
  if (!options.max_cells || options.max_error)
    within = tin_of(history(), nodes_within(history(), tolerance), kLinks);
  if (!options.max_cells || (options.max_error && within.triangles.size() <= *options.max_cells))
    return within;
  const auto nodes = nodes_of_cells(history(), *options.max_cells);
  report.budget_met = nodes.has_value();
  delaunay::Tin tin = tin_of(history(), nodes.value_or(insertions::NodeSet(0)), kLinks);
  report.is_within_error = largest_error(tin) <= tolerance;
  return tin;
}

BuiltTerrainInfo InsertionsTerrain::describe_source() const {
  BuiltTerrainInfo info;
  info.sample_type = history().sample_type;
  info.has_place = history().has_place;
  info.n_nodes = history().n_nodes();
  info.n_base_triangles = history().n_base_triangles();
  info.n_triangles = history().triangles.size();
  info.memory_bytes = history().n_bytes();
  info.n_lines = history().lines.size();
  info.is_of_points = history().is_of_points;
  info.n_samples = history().n_samples;
  info.n_missing = history().n_missing;
  info.n_left_out = history().n_left_out;
  info.range = history().range;
  info.max_error = history().max_error;
  return info;
}

Result<BuiltTerrainInfo> InsertionsTerrain::describe(Progress& progress) const {
  const History& history = levelled_.history;
  BuiltTerrainInfo info = describe_source();
  const auto add = [&](double tolerance, std::uint32_t time) {
    const delaunay::Tin tin = tin_at(history, time, delaunay::TinLinks::kept);
    const TinAngles angles = measure_angles(tin, history.frame, {});
    if (!history.is_worst_first()) tolerance = largest_error(tin);
    info.levels.push_back(
        {tolerance, tin.triangles.size(), tin.vertices.size(), angles.smallest, angles.median});
  };
  for (const double tolerance : levelled_.levels) {
    if (progress.is_cancelled()) return cancelled_error();
    add(tolerance, time_within(history, tolerance));
  }
  for (const std::uint32_t end : history.level_ends) {
    if (progress.is_cancelled()) return cancelled_error();
    add(0, end);
  }
  return info;
}

}  // namespace lode
