#include "lode/api/terrain_breaklines.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "lode/locate/tin_height.h"
#include "lode/locate/tin_locator.h"
#include "lode/models/terrain/terrain_lines/line_laying.h"
#include "lode/models/terrain/terrain_lines/noding.h"

namespace lode {
namespace {

using delaunay_selector::PointDomain;
using Edge = FixedLines::Edge;

/// Lines to columns and rows of the surface.
Result<std::vector<PlaceLine>> to_surface(std::span<const PlaceLine> lines,
                                          const LineGround& ground, TerrainLineReport& report) {
  constexpr double kFarthest = 0x1p40;
  constexpr double kHighest = 1e30;
  const double scale = ground.scale;
  std::vector<PlaceLine> made;
  for (const PlaceLine& line : lines) {
    PlaceLine& own = made.emplace_back();
    for (const Vec3d& p : line) {
      const Vec<double, 2> at = ground.terrain.points.lattice(p[0], p[1]);
      // On the lattice, so that what is on the outline but for rounding is on it.
      own.push_back({{std::round(at[0]) / scale, std::round(at[1]) / scale, p[2]}});
      const auto to = ground.terrain.points.world(std::round(at[0]), std::round(at[1]));
      report.largest_move = std::max(report.largest_move, std::hypot(to[0] - p[0], to[1] - p[1]));
      if (!(std::abs(own.back()[0]) <= kFarthest && std::abs(own.back()[1]) <= kFarthest))
        return fail("expected breaklines within {} columns and rows of the samples, got {}, {}",
                    kFarthest, p[0], p[1]);
      if (std::abs(p[2]) > kHighest)
        return fail("expected heights of breaklines up to {}, got {}", kHighest, p[2]);
    }
  }
  return made;
}

void count_replaced(double height, double by, TerrainLineReport& report) {
  const double change = std::abs(by - height);
  report.n_replaced += static_cast<std::uint64_t>(change > 0);
  report.largest_change = std::max(report.largest_change, change);
}

/// Puts nodes among the points: with heights of their own, those of the sample there, or the
/// surface's. Returns the numbers that they have.
std::vector<std::uint32_t> add_nodes(HeightPoints& points, const terrain_lines::NodedLines& noded,
                                     const TinLocator& surface, double scale,
                                     std::vector<std::uint32_t>& moved_to,
                                     TerrainLineReport& report) {
  const HeightPoints before = points;
  points.nodes.clear();
  points.heights.clear();
  std::vector<std::uint32_t> numbers(noded.nodes.size());
  moved_to.resize(before.nodes.size());
  std::size_t i = 0;
  std::size_t k = 0;
  while (i < before.nodes.size() || k < noded.nodes.size()) {
    const auto number = static_cast<std::uint32_t>(points.nodes.size());
    const bool has_old =
        i < before.nodes.size() &&
        (k == noded.nodes.size() || !is_before_in_rows(noded.nodes[k], before.nodes[i]));
    const bool has_new =
        k < noded.nodes.size() &&
        (i == before.nodes.size() || !is_before_in_rows(before.nodes[i], noded.nodes[k]));
    const LatticePoint node = has_old ? before.nodes[i] : noded.nodes[k];
    points.nodes.push_back(node);
    const bool is_own = has_new && !std::isnan(noded.own_heights[k]);
    if (is_own) {
      points.heights.push_back(noded.own_heights[k]);
      if (has_old) count_replaced(before.heights[i], noded.own_heights[k], report);
    } else if (has_old) {
      points.heights.push_back(before.heights[i]);
    } else {
      const delaunay::Point at{{node.x / scale, node.y / scale}};
      const auto triangle = surface.find(at);
      // What rounding has put outside will be no part of the domain.
      points.heights.push_back(triangle ? height_in(surface.tin(), *triangle, at).height
                                        : before.heights.front());
    }
    if (has_old) moved_to[i++] = number;
    if (has_new) numbers[k++] = number;
  }
  return numbers;
}

/// Gives points on breaklines with own heights those.
class OnLines {
 public:
  OnLines(const delaunay_selector::LinedDomain& lined, const FixedLines& fixed,
          HeightPoints& points, TerrainLineReport& report)
      : lined_(lined), fixed_(fixed), points_(points), report_(report) {}

  void run() {
    if (fixed_.is_own.empty()) return;
    const auto& lines = lined_.domain.lines;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::uint32_t line = lined_.line_of[i];
      if (!fixed_.is_own[line]) continue;
      // Corners of the outline and single points lie on lines, too.
      for (const std::uint32_t p : lines[i]) put(p, fixed_.edges[line]);
      const auto [a, b] = std::minmax(lines[i][0], lines[i][1]);
      own_.push_back({a, b});
    }
    std::ranges::sort(own_);
    for (std::uint32_t p = 0; p < points_.nodes.size(); ++p) put_between(p);
  }

 private:
  void put(std::uint32_t p, const Edge& line) {
    if (p == line[0] || p == line[1]) return;
    const LatticePoint at = points_.nodes[p];
    const LatticePoint from = points_.nodes[line[0]];
    const LatticePoint to = points_.nodes[line[1]];
    const double t =
        std::hypot(at.x - from.x, at.y - from.y) / std::hypot(to.x - from.x, to.y - from.y);
    const double height = points_.heights[line[0]] * (1 - t) + points_.heights[line[1]] * t;
    count_replaced(points_.heights[p], height, report_);
    points_.heights[p] = height;
  }
  void put_between(std::uint32_t p) {
    const std::uint32_t triangle = lined_.domain.triangle_of[p];
    if (triangle == delaunay::kNoHalfEdge) return;
    const auto& corner = lined_.domain.triangles[triangle];
    if (std::ranges::find(corner, p) != corner.end()) return;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(corner[i], corner[(i + 1) % 3]);
      const bool is_on =
          delaunay::doubled_area(points_.nodes[a], points_.nodes[b], points_.nodes[p]) == 0;
      if (is_on && std::ranges::binary_search(own_, Edge{a, b})) return put(p, {a, b});
    }
  }

  const delaunay_selector::LinedDomain& lined_;
  const FixedLines& fixed_;
  HeightPoints& points_;
  TerrainLineReport& report_;
  std::vector<Edge> own_;  ///< Sorted.
};

}  // namespace

Result<void> add_breaklines(LineGround& ground, const TerrainLineOptions& options,
                            FixedLines& fixed, TerrainLineReport& report, Progress& progress) {
  HeightPoints& points = ground.terrain.points;
  const TinLocator locator(ground.surface);
  LODE_TRY(const std::vector<PlaceLine> lines, to_surface(options.breaklines, ground, report));
  LODE_TRY(terrain_lines::LaidLines laid,
           terrain_lines::lay_lines(lines, locator,
                                    {.is_draped = options.is_draped,
                                     .max_error = options.drape_error,
                                     .step = ground.step,
                                     .pull = ground.pull},
                                    progress));
  report.n_breaklines = options.breaklines.size();
  report.n_points = options.n_points;
  report.n_own_heights = laid.n_own;
  report.drape_error = options.drape_error;
  report.n_outside = laid.n_outside;
  report.n_cut = laid.n_cut;
  if (laid.parts.empty()) return {};
  const double scale = ground.scale;
  for (terrain_lines::LineToNode& part : laid.parts)
    for (Vec3d& p : part.places) p = {{p[0] * scale, p[1] * scale, p[2]}};
  for (const auto& [a, b] : fixed.edges) {
    PlaceLine& line = laid.parts.emplace_back().places;
    for (const std::uint32_t end : {a, b})
      line.push_back({{static_cast<double>(points.nodes[end].x),
                       static_cast<double>(points.nodes[end].y), points.heights[end]}});
  }
  LODE_TRY(const terrain_lines::NodedLines noded, terrain_lines::node_lines(laid.parts));
  report.n_unequal = noded.n_unequal;
  report.largest_spread = noded.largest_spread;
  std::vector<std::uint32_t> moved_to;
  const std::vector<std::uint32_t> numbers =
      add_nodes(points, noded, locator, scale, moved_to, report);
  fixed.edges.clear();
  for (std::size_t i = 0; i < noded.edges.size(); ++i) {
    const auto [a, b] = std::minmax(numbers[noded.edges[i][0]], numbers[noded.edges[i][1]]);
    fixed.edges.push_back({a, b});
    fixed.is_own.push_back(noded.is_own[i]);
  }
  for (std::uint32_t& point : fixed.single) point = moved_to[point];
  PointDomain& domain = ground.terrain.domain;
  for (auto& corner : domain.triangles)
    for (std::uint32_t& point : corner) point = moved_to[point];
  for (auto& edge : domain.outline)
    for (std::uint32_t& point : edge) point = moved_to[point];
  return {};
}

void put_points_on_lines(const delaunay_selector::LinedDomain& lined, const FixedLines& fixed,
                         HeightPoints& points, TerrainLineReport& report) {
  OnLines(lined, fixed, points, report).run();
}

}  // namespace lode
