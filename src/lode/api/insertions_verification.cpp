#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "lode/api/insertions_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/api/vertex_checks.h"
#include "lode/mappers/point_errors.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode {
namespace {

using insertions::History;

/// All triangles that there ever were.
delaunay::Tin all_triangles(const History& history) {
  delaunay::Tin tin;
  tin.vertices = history.vertices;
  tin.heights = history.heights;
  for (const auto& triangle : history.triangles) {
    tin.triangles.push_back(triangle.corner);
    tin.errors.push_back(triangle.error);
  }
  return tin;
}

/// Tolerances, and when they are kept.
std::vector<std::pair<double, std::uint32_t>> levels_to_check(const History& history,
                                                              const std::vector<double>& levels) {
  std::vector<std::pair<double, std::uint32_t>> checked;
  checked.reserve(levels.size() + history.level_ends.size() + 1);
  for (const double tolerance : levels)
    checked.emplace_back(tolerance, time_within(history, tolerance));
  for (const std::uint32_t end : history.level_ends) {
    const delaunay::Tin tin = tin_at(history, end, delaunay::TinLinks::kept);
    checked.emplace_back(static_cast<double>(*std::ranges::max_element(tin.errors)), end);
  }
  // All that there is keeps the finest error.
  checked.emplace_back(history.max_error, history.n_nodes());
  return checked;
}

}  // namespace

template <typename Verify>
Result<void> InsertionsTerrain::verify_levels(const Verify& verify_tin, Threads threads,
                                              VerifyReport& report) const {
  for (const auto& [tolerance, time] : levels_to_check(history(), levelled_.levels)) {
    const delaunay::Tin tin = tin_at(history(), time, delaunay::TinLinks::left_out);
    LODE_TRY(const VerifyReport level,
             verify_tin(
                 tin, TerrainVerifyOptions{
                          .max_error = tolerance, .shape = shape_of(model()), .threads = threads}));
    for (const VerifyReport::Check& check : level.checks)
      report.add(fmt::format("within {}: {}", tolerance, check.name), check.count,
                 check.passed ? 0 : 1, check.detail);
  }
  return {};
}

Result<VerifyReport> InsertionsTerrain::verify(const PointTerrain& terrain, Threads threads,
                                               Progress& progress) const {
  VerifyReport report;
  LODE_CHECK(check_source(history(), terrain, report));
  check_vertices(history().vertices, history().heights, terrain.points, report);
  check_lines(history().vertices, history().lines, terrain, report);
  LODE_CHECK(verify_levels(
      [&](const delaunay::Tin& tin, const TerrainVerifyOptions& options) {
        return verify_point_tin(terrain, tin, options, progress);
      },
      threads, report));
  LODE_TRY(const std::uint64_t n_beyond,
           count_understated_points(all_triangles(history()), terrain.points, threads, progress));
  report.add("triangles of all times state their errors", history().triangles.size(), n_beyond,
             n_beyond > 0 ? fmt::format("{} have points that err by more", n_beyond) : "");
  return report;
}

Result<VerifyReport> InsertionsTerrain::verify(const HeightGrid& grid, Threads threads,
                                               Progress& progress) const {
  const History& history = levelled_.history;
  VerifyReport report;
  LODE_CHECK(check_source(history, grid, report));
  check_vertices(history.vertices, history.heights, grid, report);
  LODE_CHECK(verify_levels(
      [&](const delaunay::Tin& tin, const TerrainVerifyOptions& options) {
        return verify_sample_tin(grid, tin, options, progress);
      },
      threads, report));
  LODE_CHECK(check_stated_errors(all_triangles(history), 1, grid,
                                 "triangles of all times state their errors", threads, progress,
                                 report));
  return report;
}

Result<VerifyReport> InsertionsTerrain::verify_alone(Threads /*threads*/,
                                                     Progress& /*progress*/) const {
  VerifyReport report;
  report.add("vertices make the triangles again", history().triangles.size(), 0, "");
  return report;
}

}  // namespace lode
