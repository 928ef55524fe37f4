#include "lode/api/bisection_terrain.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "lode/api/terrain_focus.h"
#include "lode/core/stopwatch.h"
#include "lode/delaunay/tin_links.h"
#include "lode/mappers/tin_quality.h"
#include "lode/models/terrain/right_triangle_bisection/extract.h"

namespace lode {

using bisection::Bisection;
using bisection_file::BisectionModel;

namespace {

/// Coarser than any error.
constexpr double kNoTolerance = std::numeric_limits<double>::max();

}  // namespace

Result<BisectionTerrain> BisectionTerrain::build(const HeightGrid& grid,
                                                 const TerrainBuildOptions& options,
                                                 std::vector<double> levels, Progress& progress) {
  LODE_TRY(terrain_file::Source source, source_of(grid, options));
  LODE_TRY(Bisection tree, Bisection::build(grid, {}, progress));
  tree.keep(options.kept);
  return BisectionTerrain(
      BisectionModel{std::move(source), std::move(levels), grid, std::move(tree)});
}

Result<BisectionTerrain> BisectionTerrain::open(const std::string& path, Progress& progress) {
  LODE_TRY(BisectionModel model, bisection_file::open(path, {}, progress));
  return BisectionTerrain(std::move(model));
}

delaunay::Tin BisectionTerrain::tin_for(const TerrainOptions& options,
                                        TerrainReport& report) const {
  double tolerance = report.max_error;
  if (options.max_cells) {
    const auto of_cells = bisection::tolerance_of_cells(model_.tree, *options.max_cells);
    report.budget_met = of_cells.has_value();
    // A tolerance that fewer triangles keep is not made finer.
    tolerance = std::max(of_cells.value_or(kNoTolerance), options.max_error ? tolerance : 0);
  }
  return tin_within(model_.tree, model_.grid, tolerance, options.threads);
}

Result<SelectedTerrain> BisectionTerrain::select(const TerrainOptions& options,
                                                 delaunay::TinLinks links,
                                                 Progress& progress) const {
  const Stopwatch watch;
  if (progress.is_cancelled()) return cancelled_error();
  SelectedTerrain selected;
  TerrainReport& report = selected.report;
  report.max_error = default_tolerance(options, source().range);
  if (options.focus) {
    if (options.max_cells) return fail(kFocusOrCells);
    LODE_TRY(const TerrainDemand focus,
             TerrainDemand::make(*options.focus, report.max_error, source().frame, source().range));
    selected.tin = tin_of(model_.tree, model_.grid,
                          select_nodes(model_.tree, model_.grid, source().range, focus.demand()));
    report_focus(focus, source().frame, selected);
  } else {
    selected.tin = tin_for(options, report);
  }
  if (progress.is_cancelled()) return cancelled_error();
  if (links == delaunay::TinLinks::kept)
    selected.tin.twins = delaunay::find_twins(selected.tin.triangles);
  count_selection(source(), selected);
  report.achieved_error = largest_error(selected.tin);
  if (!options.focus) report.is_within_error = report.achieved_error <= report.max_error;
  report.seconds = watch.seconds();
  return selected;
}

Result<SelectedTerrain> BisectionTerrain::select_all(Progress& progress) const {
  return select_terrain(model_.grid, {.max_error = 0}, delaunay::TinLinks::kept, progress);
}

Result<std::uint64_t> BisectionTerrain::save(const std::string& path, Progress& progress) const {
  return bisection_file::save(model_, path, progress);
}

BuiltTerrainInfo BisectionTerrain::describe_source() const {
  BuiltTerrainInfo info;
  info.sample_type = source().sample_type;
  info.has_place = source().has_place;
  info.n_samples = source().n_samples;
  info.n_missing = source().n_missing;
  info.n_left_out = source().n_left_out;
  info.range = source().range;
  info.n_kept = model_.tree.kept().size();
  info.n_nodes = source().n_samples;
  info.n_base_triangles =
      count_triangles(model_.tree, kNoTolerance, std::numeric_limits<std::uint32_t>::max());
  info.memory_bytes = model_.tree.n_bytes() +
                      std::visit(
                          [](const auto& samples) {
                            return static_cast<std::uint64_t>(samples.size() * sizeof samples[0]);
                          },
                          model_.grid.heights) +
                      model_.grid.is_valid.size();
  return info;
}

Result<BuiltTerrainInfo> BisectionTerrain::describe(Progress& progress) const {
  BuiltTerrainInfo info = describe_source();
  for (const double tolerance : model_.levels) {
    if (progress.is_cancelled()) return cancelled_error();
    const delaunay::Tin tin = tin_within(model_.tree, model_.grid, tolerance);
    const TinAngles angles = measure_angles(tin, source().frame, {});
    info.levels.push_back(
        {tolerance, tin.triangles.size(), tin.vertices.size(), angles.smallest, angles.median});
  }
  return info;
}

}  // namespace lode
