#include "lode/api/terrain_lines.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "lode/api/terrain_breaklines.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/delaunay/full_tin.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/delaunay_selector/selector.h"
#include "lode/models/terrain/terrain_lines/straight_runs.h"

namespace lode {
namespace {

using delaunay_selector::PointDomain;
using Edge = FixedLines::Edge;

/// Whether lists of nodes in rows have one, and where.
std::optional<std::uint32_t> number_of(std::span<const LatticePoint> nodes, LatticePoint p) {
  const auto found = std::ranges::lower_bound(nodes, p, is_before_in_rows);
  if (found == nodes.end() || *found != p) return std::nullopt;
  return static_cast<std::uint32_t>(found - nodes.begin());
}

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
Result<void> add_features(const LineGround& ground, double least_relief, bool has_breaklines,
                          FixedLines& fixed, TerrainLineReport& report, Progress& progress) {
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

Result<LinedTerrain> add_lines_to(LineGround ground, const TerrainLineOptions& options,
                                  Progress& progress) {
  LODE_EXPECTS(!options.least_relief || *options.least_relief >= 0);
  const Stopwatch watch;
  LinedTerrain made;
  FixedLines fixed;
  if (options.least_relief)
    LODE_CHECK(add_features(ground, *options.least_relief, !options.breaklines.empty(), fixed,
                            made.report, progress));
  if (!options.breaklines.empty())
    LODE_CHECK(add_breaklines(ground, options, fixed, made.report, progress));
  ground.surface = {};
  LODE_TRY(delaunay_selector::LinedDomain lined,
           delaunay_selector::with_lines(ground.terrain.points, ground.terrain.domain, fixed.edges,
                                         fixed.single, progress));
  put_points_on_lines(lined, fixed, ground.terrain.points, made.report);
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
  LineGround ground;
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
  LineGround ground;
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
