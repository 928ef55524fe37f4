#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/point_terrain.h"
#include "lode/api/terrain_lines.h"
#include "lode/delaunay/tin.h"
#include "tests/delaunay/point_fixtures.h"
#include "tests/terrain/height_grids.h"

namespace lode::test {

inline double rough_hills(double x, double y) {
  return 40 * std::sin(x / 9) * std::cos(y / 7) + 7 * std::sin(x * y / 90) + x / 5;
}

/// Whole numbers up to `size`, so that many are on lines and circles where it is small.
inline PointTerrain scattered(int n, std::int32_t size, std::uint64_t seed,
                              const PointTerrainOptions& options = {}) {
  std::vector<Vec3d> points;
  for (const LatticePoint& p : delaunay::test::random_nodes(n, size, seed)) {
    const double scale = 60.0 / size;
    points.push_back({{static_cast<double>(p.x), static_cast<double>(p.y),
                       std::round(4 * rough_hills(scale * p.x, scale * p.y)) / 4}});
  }
  Progress progress;
  auto made = make_point_terrain(points, {{0, 0}, 1}, {}, options, progress);
  EXPECT_TRUE(made) << made.error().message;
  return *std::move(made);
}

/// Crossing lines: with heights of their own, draped, and one that leaves the domain.
inline TerrainLineOptions some_lines(double size) {
  TerrainLineOptions lines{.drape_error = 2};
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  lines.breaklines.push_back({{{{0.2 * size, 0.3 * size, 5}}, {{0.7 * size, 0.6 * size, 15}}}});
  lines.breaklines.push_back(
      {{{{0.3 * size, 0.7 * size, kNaN}}, {{0.6 * size, 0.25 * size, kNaN}}}});
  lines.breaklines.push_back({{{{0.5 * size, 0.5 * size, kNaN}}, {{2 * size, 0.55 * size, kNaN}}}});
  return lines;
}

/// Triangles that turn left, each edge once each way; what is left goes along the domain's outline,
/// and areas add up to that of the domain.
inline void expect_fills_domain(const delaunay::Tin& tin, std::int32_t scale,
                                const PointTerrain& terrain) {
  const auto fine = [&](std::uint32_t point) {
    const LatticePoint p = terrain.points.nodes[point];
    return LatticePoint{p.x * scale, p.y * scale};
  };
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  delaunay::test::Int128 area = 0;
  for (const auto& t : tin.triangles) {
    const std::int64_t own =
        delaunay::doubled_area(tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]]);
    EXPECT_GT(own, 0);
    area += own;
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_TRUE(edges.insert({t[i], t[(i + 1) % 3]}).second) << "an edge is used twice";
  }
  for (const auto& t : terrain.domain.triangles)
    area -= delaunay::doubled_area(fine(t[0]), fine(t[1]), fine(t[2]));
  EXPECT_TRUE(area == 0);
  for (const auto& [from, to] : edges) {
    if (edges.contains({to, from})) continue;
    const LatticePoint p = tin.vertices[from];
    const LatticePoint q = tin.vertices[to];
    EXPECT_TRUE(std::ranges::any_of(terrain.domain.outline,
                                    [&](const auto& edge) {
                                      const LatticePoint a = fine(edge[0]);
                                      const LatticePoint b = fine(edge[1]);
                                      const auto is_between = [&](LatticePoint u) {
                                        return delaunay::doubled_area(a, b, u) == 0 &&
                                               std::min(a.x, b.x) <= u.x &&
                                               u.x <= std::max(a.x, b.x) &&
                                               std::min(a.y, b.y) <= u.y &&
                                               u.y <= std::max(a.y, b.y);
                                      };
                                      return is_between(p) && is_between(q);
                                    }))
        << p.x << ", " << p.y << " to " << q.x << ", " << q.y;
  }
}

/// Pairs of points a step or two apart whose heights differ by up to 18, far from other pairs:
/// crossings of edges between them have no finer lattice to move to.
inline PointTerrain close_pairs() {
  std::vector<Vec3d> points;
  const std::vector<LatticePoint> signs = delaunay::test::random_nodes(14 * 14, 1000, 5);
  for (int y = 0; y < 14; ++y)
    for (int x = 0; x < 14; ++x) {
      const Vec3d one{{2000.0 * x + 300 * (y % 3), 2000.0 * y + 300 * (x % 3),
                       std::round(8 * rough_hills(4 * x, 4 * y)) / 8}};
      const int sign = signs[static_cast<std::size_t>(14 * y + x)].x % 2 == 0 ? 1 : -1;
      points.push_back(one);
      points.push_back(one + Vec3d{{1, 2, 9.0 * sign}});
    }
  Progress progress;
  auto made = make_point_terrain(points, {{0, 0}, 1}, {}, {}, progress);
  EXPECT_TRUE(made) << made.error().message;
  return *std::move(made);
}

struct PointCase {
  std::string name;
  PointTerrain terrain;
};

/// Of all kinds that there are.
inline std::vector<PointCase> point_cases() {
  Progress progress;
  std::vector<PointCase> all;
  all.push_back({"hull", scattered(700, 100'000, 1)});
  all.push_back({"on circles", scattered(300, 24, 2)});
  all.push_back({"part", scattered(500, 1000, 3, {.max_edge = 90})});
  all.push_back({"triangle", scattered(3, 50, 5)});
  auto lined = add_lines(scattered(600, 4096, 4), some_lines(4096), progress);
  EXPECT_TRUE(lined) << lined.error().message;
  all.push_back({"lines", std::move(lined->terrain)});
  HeightGrid grid = float_grid(31, 24, [](int x, int y) { return rough_hills(2 * x, 2 * y); });
  for (std::int32_t x = 12; x < 16; ++x) delaunay::test::set_missing(grid, x, 9);
  for (const bool has_breaklines : {false, true}) {
    TerrainLineOptions lines;
    if (has_breaklines) lines = some_lines(23);
    lines.least_relief = 10;
    auto raster = add_lines(grid, lines, progress);
    EXPECT_TRUE(raster) << raster.error().message;
    all.push_back({has_breaklines ? "raster with breaklines" : "raster with features",
                   std::move(raster->terrain)});
  }
  all.push_back({"pairs", close_pairs()});
  return all;
}

}  // namespace lode::test
