#include "lode/api/insertions_terrain.h"

#include <utility>

#include "lode/api/insertions_selection.h"
#include "lode/api/terrain_focus.h"
#include "lode/core/expects.h"
#include "lode/core/stopwatch.h"
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
  LODE_EXPECTS(is_of_any_points(model) && !is_hierarchy(model));
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

TerrainModel InsertionsTerrain::model() const { return terrain_model_of(history().model); }

Result<void> InsertionsTerrain::find_facts(Progress& progress) const {
  const std::lock_guard lock(mutex_);
  if (levelled_.facts.empty()) {
    LODE_TRY(levelled_.facts, insertions::find_facts(levelled_, progress));
  }
  return {};
}

Result<std::uint64_t> InsertionsTerrain::save(const std::string& path, Progress& progress) const {
  LODE_CHECK(find_facts(progress));
  return insertions::save(levelled_, path, progress);
}

Result<SelectedTerrain> InsertionsTerrain::select(const TerrainOptions& options, delaunay::TinLinks,
                                                  Progress& progress) const {
  const Stopwatch watch;
  if (progress.is_cancelled()) return cancelled_error();
  LODE_TRY(const double tolerance,
           insertions_tolerance(options, history().range, history().max_error));
  SelectedTerrain selected;
  if (options.focus) {
    LODE_TRY(const TerrainDemand focus,
             TerrainDemand::make(*options.focus, tolerance, history().frame, history().range));
    selected.tin =
        tin_of(history(), select_nodes(history(), focus.demand()), delaunay::TinLinks::kept);
    report_focus(focus, history().frame, selected);
  } else {
    selected.tin = uniform_tin(history(), history().max_error, options, tolerance, selected.report);
  }
  const FinestMesh finest{history().max_error,
                          history().triangles.size() - history().removed.size()};
  finish_report(source(), finest, tolerance, watch, selected);
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

BuiltTerrainInfo InsertionsTerrain::describe_source() const {
  BuiltTerrainInfo info = describe_base(history());
  info.n_nodes = history().n_nodes();
  info.n_triangles = history().triangles.size();
  info.memory_bytes = history().n_bytes();
  return info;
}

Result<BuiltTerrainInfo> InsertionsTerrain::describe(Progress& progress) const {
  LODE_CHECK(find_facts(progress));
  BuiltTerrainInfo info = describe_source();
  add_levels(levelled_.facts, info);
  return info;
}

}  // namespace lode
