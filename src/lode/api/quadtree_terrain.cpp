#include "lode/api/quadtree_terrain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "lode/api/quadtree_budget.h"
#include "lode/api/quadtree_demand.h"
#include "lode/api/quadtree_patches.h"
#include "lode/api/terrain_focus.h"
#include "lode/core/stopwatch.h"
#include "lode/delaunay/tin_links.h"
#include "lode/delaunay/triangle_error.h"
#include "lode/mappers/tin_quality.h"
#include "lode/models/terrain/restricted_quadtree/restricted_quadtree.h"

namespace lode {

using quadtree_file::QuadtreeModel;
using quaternary_triangulation::QuaternaryTriangulation;
using squares::SquareDomain;
using surface_quadtree::SurfaceQuadtree;

Result<QuadtreeTerrain> QuadtreeTerrain::build(const HeightGrid& grid,
                                               const TerrainBuildOptions& options,
                                               std::vector<double> levels, Progress& progress) {
  LODE_TRY(terrain_file::Source source, source_of(grid, options));
  const auto make = [&](auto tree) {
    tree.keep(options.kept);
    return QuadtreeTerrain(
        QuadtreeModel{std::move(source), std::move(levels), grid, std::move(tree)});
  };
  if (options.model == TerrainModel::surface_quadtree) {
    LODE_TRY(auto tree, SurfaceQuadtree::build(grid, {}, progress));
    return make(std::move(tree));
  }
  if (options.model == TerrainModel::quaternary_triangulation) {
    LODE_TRY(auto tree, QuaternaryTriangulation::build(grid, {}, progress));
    return make(std::move(tree));
  }
  LODE_TRY(auto domain, SquareDomain::make(grid));
  return make(std::move(domain));
}

Result<QuadtreeTerrain> QuadtreeTerrain::open(const std::string& path, Progress& progress) {
  LODE_TRY(QuadtreeModel model, quadtree_file::open(path, progress));
  return QuadtreeTerrain(std::move(model));
}

TerrainModel QuadtreeTerrain::model() const {
  constexpr std::array kModels{TerrainModel::surface_quadtree,
                               TerrainModel::quaternary_triangulation,
                               TerrainModel::restricted_quadtree};
  return kModels[model_.tree.index()];
}

const SquareDomain& QuadtreeTerrain::domain() const { return domain_of(model_); }

delaunay::Tin QuadtreeTerrain::tin_of(const Demand& demand) const {
  const QuadtreeDemand wanted(domain(), source().frame, source().range, demand);
  if (const auto* tree = std::get_if<SurfaceQuadtree>(&model_.tree))
    return to_tin(*tree, wanted.leaves(*tree));
  const auto& tree = std::get<QuaternaryTriangulation>(model_.tree);
  return to_tin(tree, wanted.leaves(tree));
}

void QuadtreeTerrain::measure_errors(delaunay::Tin& tin) const {
  if (model() != TerrainModel::surface_quadtree) return;
  for (std::size_t t = 0; t < tin.triangles.size(); ++t)
    tin.errors[t] = delaunay::to_float_above(worst_error_in(tin, t, 1, model_.grid));
}

Result<void> QuadtreeTerrain::judge_triangles(const TerrainFocus& focus,
                                              SelectedTerrain& selected) const {
  TerrainReport& report = selected.report;
  const delaunay::Tin& tin = selected.tin;
  LODE_TRY(const TerrainDemand demand,
           TerrainDemand::make(focus, report.max_error, source().frame, source().range));
  const QuadtreeDemand wanted(domain(), source().frame, source().range, demand.demand());
  const auto is_beyond = [&](std::span<const LatticePoint> corners, double error) {
    return error > 0 && wanted.wants(corners, error);
  };
  std::vector<bool> is_counted(static_cast<std::size_t>(model_.grid.n_samples()));
  const auto count = [&](LatticePoint p, double error) {
    const auto at = static_cast<std::size_t>(std::int64_t{p.y} * domain().size_x() + p.x);
    if (!is_beyond(std::array{p}, error)) return;
    report.n_beyond += is_counted[at] ? 0 : 1;
    is_counted[at] = true;
    report.worst_beyond = std::max(report.worst_beyond, error);
  };
  for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
    std::array<LatticePoint, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = tin.vertices[tin.triangles[t][i]];
    // A sample is asked no more than a triangle that it lies in.
    if (is_beyond(corners, worst_error_in(tin, t, 1, model_.grid)))
      visit_errors_in(tin, t, 1, model_.grid, count);
  }
  if (report.n_beyond > 0) report.is_within_error = false;
  return {};
}

Result<delaunay::Tin> QuadtreeTerrain::tin_within(double tolerance, Progress& progress) const {
  if (const auto* tree = std::get_if<SurfaceQuadtree>(&model_.tree))
    return to_tin(*tree, tree->leaves(tolerance));
  if (const auto* tree = std::get_if<QuaternaryTriangulation>(&model_.tree))
    return to_tin(*tree, tree->leaves(tolerance));
  LODE_TRY(const auto leaves, restricted_quadtree::build(domain(), tolerance, progress));
  return to_tin(domain(), leaves);
}

double QuadtreeTerrain::tolerance_for(const TerrainOptions& options, TerrainReport& report) const {
  if (!options.max_cells) return report.max_error;
  const auto* tree = std::get_if<SurfaceQuadtree>(&model_.tree);
  const auto of_cells =
      tree != nullptr
          ? tolerance_of_cells(*tree, *options.max_cells)
          : tolerance_of_cells(std::get<QuaternaryTriangulation>(model_.tree), *options.max_cells);
  report.budget_met = of_cells.has_value();
  // A tolerance that fewer triangles keep is not made finer.
  constexpr double kAnyError = std::numeric_limits<double>::max();
  return std::max(of_cells.value_or(kAnyError), options.max_error ? report.max_error : 0);
}

Result<void> QuadtreeTerrain::check_options(const TerrainOptions& options) const {
  const char* name = name_of(model());
  if (options.max_cells && !has_gaps())
    return fail(
        "expected a tolerance for {}, got a number of triangles: it keeps no errors, is made anew "
        "for each tolerance, and a smaller one need not make more triangles, as midpoints are "
        "added one by one; the other quadtrees, a right_triangle_bisection and the pyramids find "
        "the finest mesh of a number",
        name);
  if (options.max_cells && options.focus) return fail(kFocusOrCells);
  if (options.focus && !has_gaps())
    return fail("expected one tolerance for {}, which has gaps where it varies, got a focus", name);
  return {};
}

Result<SelectedTerrain> QuadtreeTerrain::select_mesh(const TerrainOptions& options,
                                                     Progress& progress) const {
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(check_options(options));
  SelectedTerrain selected;
  TerrainReport& report = selected.report;
  report.max_error = default_tolerance(options, source().range);
  if (options.focus) {
    LODE_TRY(const TerrainDemand focus,
             TerrainDemand::make(*options.focus, report.max_error, source().frame, source().range));
    selected.tin = tin_of(focus.demand());
    if (options.focus->view) measure_errors(selected.tin);
    report_focus(focus, source().frame, selected);
  } else {
    LODE_TRY(selected.tin, tin_within(tolerance_for(options, report), progress));
  }
  count_selection(source(), selected);
  return selected;
}

Result<SelectedTerrain> QuadtreeTerrain::select_triangles(const TerrainOptions& options,
                                                          Progress& progress) const {
  LODE_TRY(SelectedTerrain selected, select(options, delaunay::TinLinks::left_out, progress));
  const Stopwatch watch;
  measure_errors(selected.tin);
  selected.tin.twins = delaunay::find_twins(selected.tin.triangles);
  selected.report.seconds += watch.seconds();
  return selected;
}

Result<SelectedTerrain> QuadtreeTerrain::select(const TerrainOptions& options,
                                                delaunay::TinLinks links,
                                                Progress& progress) const {
  const Stopwatch watch;
  if (has_gaps() && links == delaunay::TinLinks::kept)
    return fail(
        "expected a model without gaps, got {}: where its squares differ in size its surface "
        "breaks off, and so would lines that go on from triangle to triangle; restricted_quadtree "
        "and the pyramids go on",
        name_of(model()));
  LODE_TRY(SelectedTerrain selected, select_mesh(options, progress));
  TerrainReport& report = selected.report;
  if (links == delaunay::TinLinks::kept)
    selected.tin.twins = delaunay::find_twins(selected.tin.triangles);
  // Bilinear squares are no triangles, whose errors are others.
  report.achieved_error = model() == TerrainModel::surface_quadtree
                              ? measure_quality(selected.tin, 1, model_.grid, {}).worst_error
                              : largest_error(selected.tin);
  // Its squares are within the tolerance before errors are rounded up to floats.
  if (!has_gaps()) report.achieved_error = std::min(report.achieved_error, report.max_error);
  if (!options.focus)
    report.is_within_error = report.achieved_error <= report.max_error;
  else if (model() == TerrainModel::surface_quadtree)
    LODE_CHECK(judge_triangles(*options.focus, selected));
  report.seconds = watch.seconds();
  return selected;
}

Result<std::shared_ptr<const TerrainPatches>> QuadtreeTerrain::patches(
    const TerrainOptions& options, Progress& progress) const {
  if (!has_gaps()) return std::shared_ptr<const TerrainPatches>{};
  const Stopwatch watch;
  LODE_TRY(SelectedTerrain selected, select_mesh(options, progress));
  selected.report.seconds = watch.seconds();
  LODE_TRY(QuadtreePatches patches,
           QuadtreePatches::make(model_, std::move(selected), options, progress));
  return std::shared_ptr<const TerrainPatches>(
      std::make_shared<const QuadtreePatches>(std::move(patches)));
}

Result<SelectedTerrain> QuadtreeTerrain::select_all(Progress& progress) const {
  return select_terrain(model_.grid, {.max_error = 0}, delaunay::TinLinks::kept, progress);
}

Result<std::uint64_t> QuadtreeTerrain::save(const std::string& path, Progress& progress) const {
  return quadtree_file::save(model_, path, progress);
}

BuiltTerrainInfo QuadtreeTerrain::describe_source() const {
  BuiltTerrainInfo info;
  info.sample_type = source().sample_type;
  info.has_place = source().has_place;
  info.n_samples = source().n_samples;
  info.n_missing = source().n_missing;
  info.n_left_out = source().n_left_out;
  info.range = source().range;
  info.n_kept = domain().kept().size();
  info.n_nodes = 0;
  for (std::int32_t level = 0; level < domain().n_levels(); ++level)
    info.n_nodes += domain().n_squares(level);
  info.memory_bytes = static_cast<std::uint64_t>(model_.grid.n_samples()) * sizeof(double);
  if (const auto* tree = std::get_if<SurfaceQuadtree>(&model_.tree))
    info.memory_bytes = tree->n_bytes();
  if (const auto* tree = std::get_if<QuaternaryTriangulation>(&model_.tree))
    info.memory_bytes = tree->n_bytes();
  return info;
}

Result<BuiltTerrainInfo> QuadtreeTerrain::describe(Progress& progress) const {
  BuiltTerrainInfo info = describe_source();
  for (const double tolerance : model_.levels) {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_TRY(const delaunay::Tin tin, tin_within(tolerance, progress));
    const TinAngles angles = measure_angles(tin, source().frame, {});
    info.levels.push_back(
        {tolerance, tin.triangles.size(), tin.vertices.size(), angles.smallest, angles.median});
  }
  return info;
}

}  // namespace lode
