#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "lode/api/insertions_terrain.h"
#include "lode/mappers/point_errors.h"
#include "lode/mappers/tin_surface.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode {
namespace {

using delaunay::LatticePoint;
using insertions::History;

/// The height of each vertex.
void check_vertices(const History& history, const HeightGrid& grid, VerifyReport& report) {
  std::uint64_t n_other = 0;
  for (std::size_t v = 0; v < history.vertices.size(); ++v) {
    const delaunay::LatticePoint p = history.vertices[v];
    if (!grid.has_height(p.x, p.y) || grid.height(p.x, p.y) != history.heights[v]) ++n_other;
  }
  report.add("vertices have the samples' heights", history.vertices.size(), n_other,
             n_other > 0 ? fmt::format("{} have others", n_other) : "");
}

void check_vertices(const History& history, const HeightPoints& points, VerifyReport& report) {
  const auto place = [](LatticePoint p) { return std::pair(p.y, p.x); };
  std::uint64_t n_other = 0;
  for (std::size_t v = 0; v < history.vertices.size(); ++v) {
    const LatticePoint p = history.vertices[v];
    const auto at = std::ranges::lower_bound(points.nodes, place(p), {}, place);
    const bool is_point = at != points.nodes.end() && *at == p;
    if (!is_point ||
        points.heights[static_cast<std::size_t>(at - points.nodes.begin())] != history.heights[v])
      ++n_other;
  }
  report.add("vertices have the points' heights", history.vertices.size(), n_other,
             n_other > 0 ? fmt::format("{} have others", n_other) : "");
}

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

template <typename Origin>
Result<void> InsertionsTerrain::verify_levels(const Origin& origin, Threads threads,
                                              VerifyReport& report, Progress& progress) const {
  for (const auto& [tolerance, time] : levels_to_check(history(), levelled_.levels)) {
    const delaunay::Tin tin = tin_at(history(), time, delaunay::TinLinks::left_out);
    const Surface surface = to_surface(tin, history().frame).surface;
    LODE_TRY(
        const VerifyReport level,
        verify_terrain(origin, surface,
                       {.max_error = tolerance, .shape = shape_of(model()), .threads = threads},
                       progress));
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
  check_vertices(history(), terrain.points, report);
  LODE_CHECK(verify_levels(terrain, threads, report, progress));
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
  check_vertices(history, grid, report);
  LODE_CHECK(verify_levels(grid, threads, report, progress));
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
