#include "lode/api/terrain_lines.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/delaunay/full_tin.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/tin_links.h"
#include "lode/locate/tin_height.h"
#include "lode/locate/tin_locator.h"
#include "lode/models/terrain/delaunay_selector/selector.h"
#include "lode/models/terrain/terrain_lines/line_laying.h"
#include "lode/models/terrain/terrain_lines/noding.h"
#include "lode/models/terrain/terrain_lines/straight_runs.h"

namespace lode {
namespace {

using delaunay_selector::PointDomain;
using Edge = std::array<std::uint32_t, 2>;

/// In rows.
bool is_before(LatticePoint a, LatticePoint b) { return a.y != b.y ? a.y < b.y : a.x < b.x; }

/// Whether lists of nodes in rows have one, and where.
std::optional<std::uint32_t> number_of(std::span<const LatticePoint> nodes, LatticePoint p) {
  const auto found = std::ranges::lower_bound(nodes, p, is_before);
  if (found == nodes.end() || *found != p) return std::nullopt;
  return static_cast<std::uint32_t>(found - nodes.begin());
}

/// A terrain as points, its surface through all of them, and how much coarser the lattice of the
/// surface is.
struct Ground {
  PointTerrain terrain;
  delaunay::Tin surface;  ///< With heights and twins.
  std::int32_t scale = 1;
  double step = 1;  ///< Columns and rows of the surface that draped lines are looked at in.
  double pull = 0;  ///< See LayingOptions.
};

/// What lines are to be made of a terrain's points.
struct Fixed {
  std::vector<Edge> edges;
  std::vector<bool> is_own;  ///< By edge: points on it get its heights. Empty: none.
  std::vector<std::uint32_t> single;
};

Result<terrain_features::Features> find_features(const delaunay::Tin& surface, double least_relief,
                                                 TerrainLineReport& report, Progress& progress) {
  LODE_TRY(terrain_features::Features features,
           terrain_features::find_features(surface, least_relief, progress));
  report.least_relief = least_relief;
  report.all_features = features.all;
  report.kept_features = features.kept;
  for (const terrain_features::FeatureLine& line : features.lines)
    ++(line.kind == terrain_features::LineKind::ridge ? report.n_ridges : report.n_channels);
  return features;
}

/// Adds features to the lines, as edges of points.
Result<void> add_features(const Ground& ground, double least_relief, bool has_breaklines,
                          Fixed& fixed, TerrainLineReport& report, Progress& progress) {
  LODE_TRY(const terrain_features::Features features,
           find_features(ground.surface, least_relief, report, progress));
  const std::int32_t scale = ground.scale;
  const auto point_of = [&](std::uint32_t vertex) {
    const LatticePoint p = ground.surface.vertices[vertex];
    const auto number = number_of(ground.terrain.points.nodes, {p.x * scale, p.y * scale});
    LODE_EXPECTS(number.has_value());
    return *number;
  };
  std::vector<Edge> steps;
  for (const terrain_features::FeatureLine& line : features.lines)
    for (std::size_t i = 1; i < line.vertices.size(); ++i)
      steps.push_back({point_of(line.vertices[i - 1]), point_of(line.vertices[i])});
  for (const terrain_features::CriticalPoint& point : features.points)
    fixed.single.push_back(point_of(point.vertex));
  // Where breaklines cross them, what becomes of longer edges is no longer known.
  if (has_breaklines)
    fixed.edges = std::move(steps);
  else
    fixed.edges = terrain_lines::straight_runs(ground.terrain.points.nodes, steps, fixed.single);
  return {};
}

/// Lines to columns and rows of the surface.
Result<std::vector<PlaceLine>> to_surface(std::span<const PlaceLine> lines, const Ground& ground,
                                          TerrainLineReport& report) {
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
    const bool has_old = i < before.nodes.size() &&
                         (k == noded.nodes.size() || !is_before(noded.nodes[k], before.nodes[i]));
    const bool has_new = k < noded.nodes.size() &&
                         (i == before.nodes.size() || !is_before(before.nodes[i], noded.nodes[k]));
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

/// Lays breaklines onto the surface and joins them with the lines that there are.
Result<void> add_breaklines(Ground& ground, const TerrainLineOptions& options, Fixed& fixed,
                            TerrainLineReport& report, Progress& progress) {
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

/// Gives points on breaklines with own heights those.
class OnLines {
 public:
  OnLines(const delaunay_selector::LinedDomain& lined, const Fixed& fixed, HeightPoints& points,
          TerrainLineReport& report)
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
  const Fixed& fixed_;
  HeightPoints& points_;
  TerrainLineReport& report_;
  std::vector<Edge> own_;  ///< Sorted.
};

Result<LinedTerrain> add_lines_to(Ground ground, const TerrainLineOptions& options,
                                  Progress& progress) {
  LODE_EXPECTS(!options.least_relief || *options.least_relief >= 0);
  const Stopwatch watch;
  LinedTerrain made;
  Fixed fixed;
  if (options.least_relief)
    LODE_CHECK(add_features(ground, *options.least_relief, !options.breaklines.empty(), fixed,
                            made.report, progress));
  if (!options.breaklines.empty())
    LODE_CHECK(add_breaklines(ground, options, fixed, made.report, progress));
  ground.surface = {};
  LODE_TRY(delaunay_selector::LinedDomain lined,
           delaunay_selector::with_lines(ground.terrain.points, ground.terrain.domain, fixed.edges,
                                         fixed.single, progress));
  OnLines(lined, fixed, ground.terrain.points, made.report).run();
  made.report.n_crossing = lined.n_crossing;
  made.terrain = std::move(ground.terrain);
  made.terrain.domain = std::move(lined.domain);
  made.report.n_edges = made.terrain.domain.lines.size();
  made.report.seconds = watch.seconds();
  return made;
}

/// How many times finer than a raster the lattice of its lines is.
std::int32_t line_scale(const HeightGrid& grid) {
  constexpr std::int64_t kMostNodes = std::int64_t{1} << 29;
  std::int32_t scale = 1 << 10;
  while (std::int64_t{std::max(grid.n_columns, grid.n_rows)} * scale > kMostNodes) scale /= 2;
  return scale;
}

HeightPoints to_points(const HeightGrid& grid, const delaunay::Tin& full, std::int32_t scale) {
  HeightPoints points;
  static_cast<HeightFrame&>(points) = grid;
  points.n_columns = (grid.n_columns - 1) * scale + 1;
  points.n_rows = (grid.n_rows - 1) * scale + 1;
  for (const std::size_t i : {1U, 2U, 4U, 5U}) points.to_world[i] /= scale;
  for (const LatticePoint p : full.vertices) points.nodes.push_back({p.x * scale, p.y * scale});
  points.heights = full.heights;
  return points;
}

/// The domain of a grid by numbers of its points; without triangle_of, which lines change.
Result<PointDomain> to_domain(const HeightGrid& grid, const HeightPoints& points,
                              std::int32_t scale) {
  LODE_TRY(const delaunay::GridDomain cells, delaunay::find_domain(grid));
  const delaunay::LatticePacking packing(grid.n_columns);
  PointDomain domain;
  for (const auto& corners : cells.triangles) {
    auto& triangle = domain.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const LatticePoint p = packing.unpack(corners[i]);
      const auto number = number_of(points.nodes, {p.x * scale, p.y * scale});
      LODE_EXPECTS(number.has_value());
      triangle[i] = *number;
    }
  }
  const auto twins = delaunay::find_twins(domain.triangles);
  for (std::size_t t = 0; t < twins.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      if (twins[t][i] == delaunay::kNoHalfEdge)
        domain.outline.push_back({domain.triangles[t][i], domain.triangles[t][(i + 1) % 3]});
  return domain;
}

}  // namespace

Result<std::vector<LatticePoint>> find_feature_nodes(const HeightGrid& grid, double least_relief,
                                                     TerrainLineReport& report,
                                                     Progress& progress) try {
  const Stopwatch watch;
  LODE_CHECK(delaunay::check_heights(height_range(grid)));
  LODE_TRY(const delaunay::FullTin full, delaunay::to_full_tin(grid));
  LODE_TRY(const terrain_features::Features features,
           find_features(full.tin, least_relief, report, progress));
  std::vector<std::uint32_t> vertices;
  for (const terrain_features::CriticalPoint& point : features.points)
    vertices.push_back(point.vertex);
  for (const terrain_features::FeatureLine& line : features.lines)
    vertices.insert(vertices.end(), line.vertices.begin(), line.vertices.end());
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<LatticePoint> nodes;
  nodes.reserve(vertices.size());
  // Its vertices are in rows.
  for (const std::uint32_t vertex : vertices) nodes.push_back(full.tin.vertices[vertex]);
  report.seconds = watch.seconds();
  return nodes;
} catch (const std::bad_alloc&) {
  return out_of_memory("find features");
}

Result<LinedTerrain> add_lines(const HeightGrid& grid, const TerrainLineOptions& options,
                               Progress& progress) try {
  Ground ground;
  LODE_CHECK(delaunay::check_heights(height_range(grid)));
  LODE_TRY(delaunay::FullTin full, delaunay::to_full_tin(grid));
  ground.scale = options.breaklines.empty() ? 1 : line_scale(grid);
  ground.step = 0.5;
  ground.terrain.points = to_points(grid, full.tin, ground.scale);
  LODE_TRY(ground.terrain.domain, to_domain(grid, ground.terrain.points, ground.scale));
  ground.surface = std::move(full.tin);
  LODE_TRY(LinedTerrain made, add_lines_to(std::move(ground), options, progress));
  made.terrain.n_missing = grid.n_missing();
  made.terrain.n_in_no_cell = full.n_left_out;
  return made;
} catch (const std::bad_alloc&) {
  return out_of_memory("add lines");
}

Result<LinedTerrain> add_lines(PointTerrain terrain, const TerrainLineOptions& options,
                               Progress& progress) try {
  Ground ground;
  LODE_TRY(delaunay_selector::Selection all,
           delaunay_selector::select_all_points(terrain.points, terrain.domain, progress));
  ground.surface = std::move(all.tin);
  const double area = static_cast<double>(terrain.points.n_columns) * terrain.points.n_rows;
  ground.step =
      std::max(1.0, 0.5 * std::sqrt(area / static_cast<double>(terrain.points.nodes.size())));
  constexpr double kOffTheOutline = 2;
  ground.pull = kOffTheOutline;
  ground.terrain = std::move(terrain);
  return add_lines_to(std::move(ground), options, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("add lines");
}

}  // namespace lode
