#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "lode/api/insertions_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/mappers/point_errors.h"
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

/// A line's edge, from the end that is first in rows on.
using FixedEdge = std::array<std::pair<std::int32_t, std::int32_t>, 2>;

FixedEdge fixed_edge(LatticePoint a, LatticePoint b) {
  FixedEdge edge{std::pair(a.y, a.x), std::pair(b.y, b.x)};
  std::ranges::sort(edge);
  return edge;
}

/// That the file's are those of the terrain that are not on its outline.
void check_lines(const History& history, const PointTerrain& terrain, VerifyReport& report) {
  const auto& nodes = terrain.points.nodes;
  std::map<FixedEdge, int> n_sides;
  for (const auto& [a, b] : terrain.domain.lines) n_sides[fixed_edge(nodes[a], nodes[b])] = 0;
  for (const auto& corner : terrain.domain.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto found = n_sides.find(fixed_edge(nodes[corner[i]], nodes[corner[(i + 1) % 3]]));
      if (found != n_sides.end()) ++found->second;
    }
  std::vector<FixedEdge> wanted;
  for (const auto& [edge, n] : n_sides)
    if (n == 2) wanted.push_back(edge);
  std::vector<FixedEdge> own;
  own.reserve(history.lines.size());
  for (const auto& [a, b] : history.lines)
    own.push_back(fixed_edge(history.vertices[a], history.vertices[b]));
  std::ranges::sort(own);
  std::vector<FixedEdge> other;
  std::ranges::set_symmetric_difference(own, wanted, std::back_inserter(other));
  report.add("fixed edges are those of the lines", wanted.size(), other.size(),
             other.empty() ? ""
                           : fmt::format("{} here, {} there, {} of one alone", own.size(),
                                         wanted.size(), other.size()));
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
  check_vertices(history(), terrain.points, report);
  check_lines(history(), terrain, report);
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
  check_vertices(history, grid, report);
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
