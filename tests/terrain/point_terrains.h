#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/point_terrain.h"
#include "lode/api/terrain_lines.h"
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
  return all;
}

}  // namespace lode::test
