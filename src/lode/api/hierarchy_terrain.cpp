#include "lode/api/hierarchy_terrain.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "lode/api/lined_hierarchy.h"
#include "lode/api/point_hierarchy.h"
#include "lode/api/terrain_focus.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/tin_quality.h"
#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"
#include "lode/models/terrain/triangle_hierarchy/variable.h"

namespace lode {

using hierarchy_file::HierarchyModel;
using hierarchy_file::Kind;
using triangle_hierarchy::BoundedPatches;
using triangle_hierarchy::MeasuredPatches;

namespace {

Result<void> refine_levels(const triangle_hierarchy::ReferenceSurface& surface, TerrainModel kind,
                           const std::vector<double>& levels,
                           const triangle_hierarchy::FirstMesh* first, Progress& progress,
                           HierarchyModel& model) {
  if (kind == TerrainModel::adaptive_triangulation) {
    LODE_TRY(auto made, adaptive_triangulation::build(surface, levels, {}, progress, first));
    model.kind = Kind::adaptive_triangulation;
    model.hierarchy = std::move(made.hierarchy);
  } else {
    LODE_TRY(auto made, hierarchical_delaunay::build(surface, levels, {}, progress, first));
    model.kind = Kind::hierarchical_delaunay;
    model.hierarchy = std::move(made.hierarchy);
  }
  return {};
}

terrain_file::Source source_of_points(const PointTerrain& terrain,
                                      const TerrainBuildOptions& options) {
  terrain_file::Source source;
  source.frame = terrain.points;
  source.is_of_points = true;
  source.range = height_range(terrain.points);
  source.sample_type = options.sample_type;
  source.has_place = options.has_place;
  source.n_samples = terrain.points.nodes.size() - terrain.domain.n_left_out;
  source.n_missing = terrain.n_missing;
  source.n_left_out = terrain.domain.n_left_out + terrain.n_in_no_cell;
  return source;
}

}  // namespace

HierarchyTerrain::HierarchyTerrain(HierarchyModel model, Surface surface)
    : head_(head_of(model)),
      levels_(std::make_unique<LoadedLevels>(std::move(model.hierarchy))),
      surface_(std::move(surface)),
      fine_frame_(fine_frame(head_.source.frame, head_.bits)) {}

HierarchyTerrain::HierarchyTerrain(hierarchy_file::HierarchyFile file)
    : head_(file.head()),
      levels_(std::make_unique<LoadedLevels>(std::move(file))),
      fine_frame_(fine_frame(head_.source.frame, head_.bits)) {}

Result<HierarchyTerrain> HierarchyTerrain::build(const HeightGrid& grid,
                                                 const TerrainBuildOptions& options,
                                                 const std::vector<double>& levels,
                                                 Progress& progress) {
  HierarchyModel model;
  LODE_TRY(model.source, source_of(grid, options));
  LODE_TRY(auto made, triangle_hierarchy::FineGrid::make(grid));
  auto fine = std::make_unique<const triangle_hierarchy::FineGrid>(std::move(made));
  std::optional<triangle_hierarchy::FirstMesh> lined;
  if (options.lined) {
    LODE_TRY(lined, first_mesh(*options.lined, *fine, levels.front(), progress));
  }
  LODE_CHECK(
      refine_levels(*fine, options.model, levels, lined ? &*lined : nullptr, progress, model));
  return HierarchyTerrain(std::move(model), std::move(fine));
}

Result<HierarchyTerrain> HierarchyTerrain::build(const PointTerrain& terrain,
                                                 const TerrainBuildOptions& options,
                                                 const std::vector<double>& levels,
                                                 Progress& progress) {
  HierarchyModel model;
  model.source = source_of_points(terrain, options);
  LODE_TRY(auto surface, surface_of(terrain, progress));
  LODE_TRY(const auto first, first_mesh(terrain, *surface, levels.front(), progress));
  LODE_CHECK(refine_levels(*surface, options.model, levels, &first, progress, model));
  return HierarchyTerrain(std::move(model), std::move(surface));
}

Result<HierarchyTerrain> HierarchyTerrain::open(const std::string& path) {
  LODE_TRY(auto file, hierarchy_file::HierarchyFile::open(path));
  return HierarchyTerrain(std::move(file));
}

TerrainModel HierarchyTerrain::model() const {
  return head_.kind == Kind::adaptive_triangulation ? TerrainModel::adaptive_triangulation
                                                    : TerrainModel::hierarchical_delaunay;
}

Result<int> HierarchyTerrain::level_for(const TerrainOptions& options,
                                        TerrainReport& report) const {
  const double finest = finest_error();
  const double asked = default_tolerance(options, source().range);
  if (options.max_error && asked < finest)
    return fail("expected a tolerance of {} or more, which is what the model was built for, got {}",
                finest, asked);
  int level = head_.n_levels() - 1;
  if (!options.max_cells || options.max_error) level = level_within(std::max(asked, finest));
  report.max_error = options.max_cells && !options.max_error ? 0 : std::max(asked, finest);
  if (options.max_cells) {
    while (level > 0 && head_.n_triangles_in(level) > *options.max_cells) --level;
    report.budget_met = head_.n_triangles_in(level) <= *options.max_cells;
  }
  report.is_within_error = tolerance(level) <= report.max_error;
  return level;
}

int HierarchyTerrain::level_within(double asked) const {
  int level = 0;
  while (level + 1 < head_.n_levels() && tolerance(level) > asked) ++level;
  return level;
}

double HierarchyTerrain::error_of_level(const triangle_hierarchy::Hierarchy& hierarchy,
                                        int level) const {
  float worst = 0;
  const std::uint32_t end = hierarchy.triangles_until[static_cast<std::size_t>(level)];
  for (std::uint32_t t = 0; t < end; ++t)
    if (hierarchy.is_in_level(t, level)) worst = std::max(worst, hierarchy.triangles[t].error);
  // Triangles state floats, rounded up; the level keeps its tolerance up to rounding.
  const HeightRange& range = source().range;
  const double rounding = 0x1p-48 * std::max(std::abs(range.lower), std::abs(range.upper));
  return std::min(static_cast<double>(worst), tolerance(level) + rounding);
}

int HierarchyTerrain::n_levels_for(const TerrainFocus& focus, double tolerance) const {
  // What pixels come to depends on where they are.
  if (focus.view && focus.view->max_error_px) return head_.n_levels();
  const double least = std::min(tolerance, focus.max_error_outside.value_or(tolerance));
  return level_within(least) + 1;
}

Result<SelectedTerrain> HierarchyTerrain::select_focused(const TerrainOptions& options,
                                                         Progress& progress) const {
  const TerrainFocus& focus = *options.focus;
  const double finest = finest_error();
  const double tolerance = default_tolerance(options, source().range);
  for (const std::optional<double>& asked : {options.max_error, focus.max_error_outside})
    if (asked && *asked < finest)
      return fail(
          "expected a tolerance of {} or more, which is what the model was built for, got {}",
          finest, *asked);
  if (options.max_cells) return fail(kFocusOrCells);
  SelectedTerrain selected;
  TerrainReport& report = selected.report;
  LODE_TRY(const TerrainDemand demand,
           TerrainDemand::make(focus, std::max(tolerance, finest), source().frame, source().range));
  // No others than these, whichever were read before: answers depend on the question alone.
  const int n_levels = n_levels_for(focus, std::max(tolerance, finest));
  LODE_TRY(const LoadedLevels::Shared hierarchy, levels_->first(n_levels, progress));
  LODE_TRY(const auto chains, triangle_hierarchy::EdgeChains::find_in(*hierarchy));
  selected.tin = surface_ ? tin_of_demand(*hierarchy, chains, MeasuredPatches(*surface_),
                                          demand.demand(), n_levels)
                          : tin_of_demand(*hierarchy, chains, BoundedPatches(*hierarchy),
                                          demand.demand(), n_levels);
  count_selection(source(), selected);
  report_focus(demand, fine_frame_, selected);
  report.max_error = std::max(tolerance, finest);
  report.achieved_error = largest_error(selected.tin);
  return selected;
}

Result<SelectedTerrain> HierarchyTerrain::select(const TerrainOptions& options,
                                                 delaunay::TinLinks links,
                                                 Progress& progress) const {
  const Stopwatch watch;
  if (progress.is_cancelled()) return cancelled_error();
  if (options.focus) {
    LODE_TRY(SelectedTerrain focused, select_focused(options, progress));
    focused.report.seconds = watch.seconds();
    return focused;
  }
  SelectedTerrain selected;
  TerrainReport& report = selected.report;
  LODE_TRY(const int level, level_for(options, report));
  LODE_TRY(const LoadedLevels::Shared hierarchy, levels_->first(level + 1, progress));
  selected.tin = tin_of_level(*hierarchy, level, links);
  count_selection(source(), selected);
  report.achieved_error = error_of_level(*hierarchy, level);
  report.seconds = watch.seconds();
  return selected;
}

Result<std::uint64_t> HierarchyTerrain::save(const std::string& path, Progress& progress) const {
  LODE_TRY(const LoadedLevels::Shared hierarchy, all_levels(progress));
  return hierarchy_file::save({head_.source, head_.kind, *hierarchy}, path, progress);
}

BuiltTerrainInfo HierarchyTerrain::describe_source() const {
  BuiltTerrainInfo info;
  info.sample_type = source().sample_type;
  info.has_place = source().has_place;
  info.n_nodes = head_.vertices_until.back();
  info.n_base_triangles = head_.triangles_until.front();
  info.n_triangles = head_.triangles_until.back();
  info.n_lines = head_.n_lines;
  info.memory_bytes = head_.n_bytes();
  info.n_samples = source().n_samples;
  info.n_missing = source().n_missing;
  info.n_left_out = source().n_left_out;
  info.range = source().range;
  info.max_error = finest_error();
  info.is_of_points = source().is_of_points;
  return info;
}

Result<BuiltTerrainInfo> HierarchyTerrain::describe(Progress& progress) const {
  BuiltTerrainInfo info = describe_source();
  LODE_TRY(const LoadedLevels::Shared hierarchy, all_levels(progress));
  for (int level = 0; level < head_.n_levels(); ++level) {
    if (progress.is_cancelled()) return cancelled_error();
    const delaunay::Tin tin = tin_of_level(*hierarchy, level, delaunay::TinLinks::left_out);
    const TinAngles angles = measure_angles(tin, fine_frame_, {});
    info.levels.push_back({tolerance(level), tin.triangles.size(), tin.vertices.size(),
                           angles.smallest, angles.median});
  }
  return info;
}

}  // namespace lode
