#include "lode/api/insertions_selection.h"

#include <algorithm>

#include "lode/api/built_model.h"
#include "lode/api/terrain_focus.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode {

using insertions::History;

Result<double> insertions_tolerance(const TerrainOptions& options, const HeightRange& range,
                                    double finest) {
  const double tolerance = default_tolerance(options, range);
  if (options.max_error && tolerance < finest)
    return fail(
        "expected a tolerance of {} or more, which is what the model was built for, "
        "got {}",
        finest, tolerance);
  if (options.focus) {
    const auto& outside = options.focus->max_error_outside;
    if (outside && *outside < finest)
      return fail(
          "expected a tolerance of {} or more outside the focus, which is what the "
          "model was built for, got {}",
          finest, *outside);
    if (options.max_cells) return fail(kFocusOrCells);
  }
  return options.max_cells && !options.max_error ? 0.0 : std::max(tolerance, finest);
}

delaunay::Tin uniform_tin(const History& history, double max_error, const TerrainOptions& options,
                          double tolerance, TerrainReport& report) {
  constexpr auto kLinks = delaunay::TinLinks::kept;
  report.is_within_error = max_error <= tolerance;
  delaunay::Tin within;
  if (!options.max_cells || options.max_error)
    within = tin_of(history, nodes_within(history, tolerance), kLinks);
  if (!options.max_cells || (options.max_error && within.triangles.size() <= *options.max_cells))
    return within;
  const auto nodes = nodes_of_cells(history, *options.max_cells);
  report.budget_met = nodes.has_value();
  delaunay::Tin tin = tin_of(history, nodes.value_or(insertions::NodeSet(0)), kLinks);
  report.is_within_error = largest_error(tin) <= tolerance;
  return tin;
}

void finish_report(const terrain_file::Source& source, const FinestMesh& finest, double tolerance,
                   const Stopwatch& watch, SelectedTerrain& selected) {
  TerrainReport& report = selected.report;
  count_selection(source, selected);
  report.max_error = tolerance;
  report.achieved_error = largest_error(selected.tin);
  // Errors of triangles are rounded up; that of all samples is known better.
  if (report.triangles == finest.n_triangles)
    report.achieved_error = std::min(report.achieved_error, finest.max_error);
  report.seconds = watch.seconds();
}

TerrainModel terrain_model_of(insertions::Model model) {
  switch (model) {
    case insertions::Model::ternary_triangulation: return TerrainModel::ternary_triangulation;
    case insertions::Model::implicit_delaunay_pyramid:
      return TerrainModel::implicit_delaunay_pyramid;
    default: return TerrainModel::delaunay_pyramid;
  }
}

BuiltTerrainInfo describe_base(const History& history) {
  BuiltTerrainInfo info;
  info.sample_type = history.sample_type;
  info.has_place = history.has_place;
  info.n_base_triangles = history.n_base_triangles();
  info.n_lines = history.lines.size();
  info.is_of_points = history.is_of_points;
  info.n_samples = history.n_samples;
  info.n_missing = history.n_missing;
  info.n_left_out = history.n_left_out;
  info.range = history.range;
  info.max_error = history.max_error;
  return info;
}

void add_levels(std::span<const insertions::LevelFacts> facts, BuiltTerrainInfo& info) {
  for (const insertions::LevelFacts& level : facts)
    info.levels.push_back({level.tolerance, level.n_triangles, level.n_vertices,
                           level.smallest_angle, level.median_angle});
}

}  // namespace lode
