#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/random.h"

namespace lode::test {

using delaunay::LatticePoint;
using delaunay::test::make_grid;
using triangle_hierarchy::Hierarchy;

struct TerrainCase {
  const char* name;
  HeightGrid grid;
};

inline double hills_with_spikes(std::int32_t x, std::int32_t y) {
  const bool is_spike = (x * 7 + y * 13) % 61 == 0;
  return std::round(300 * std::sin(0.21 * x) * std::cos(0.17 * y)) + (is_spike ? 64 : 0);
}

/// Rasters of many sizes and kinds, with tolerances from 1000 to 0 that mean something on each.
inline std::vector<TerrainCase> terrain_cases() {
  std::vector<TerrainCase> all;
  all.push_back({"hills", make_grid<std::int16_t>(33, 33, hills_with_spikes)});
  all.push_back({"odd sizes", make_grid<float>(45, 22, hills_with_spikes)});
  all.push_back({"a strip", make_grid<std::int16_t>(2, 40, hills_with_spikes)});
  all.push_back({"a cell", make_grid<double>(2, 2, hills_with_spikes)});
  all.push_back({"flat", make_grid<float>(40, 17, [](int, int) { return 7.3; })});
  all.push_back({"a plane", make_grid<double>(
                                31, 23, [](int x, int y) { return 1234.56 + 0.1 * x - 0.7 * y; })});
  oracles::Random random(4);
  all.push_back(
      {"noise", make_grid<float>(24, 21, [&](int, int) { return random.uniform(-500, 500); })});
  all.push_back({"smooth", make_grid<double>(50, 37, [](int x, int y) {
                   return 400 * std::exp(-0.004 * ((x - 20) * (x - 20) + (y - 11) * (y - 11))) +
                          std::sqrt(1 + x);
                 })});
  TerrainCase gaps{"gaps", make_grid<std::int16_t>(38, 41, hills_with_spikes)};
  for (std::int32_t y = 10; y < 17; ++y)
    for (std::int32_t x = 5; x < 9 + y / 2; ++x) delaunay::test::set_missing(gaps.grid, x, y);
  delaunay::test::set_missing(gaps.grid, 0, 40);
  delaunay::test::set_missing(gaps.grid, 30, 30);
  all.push_back(std::move(gaps));
  TerrainCase holes{"random gaps", make_grid<float>(29, 33, hills_with_spikes)};
  for (int i = 0; i < 60; ++i)
    delaunay::test::set_missing(holes.grid, static_cast<std::int32_t>(random.below(29)),
                                static_cast<std::int32_t>(random.below(33)));
  all.push_back(std::move(holes));
  return all;
}

inline const std::vector<double> kLevels{1000, 150, 40, 7, 0.5, 0};

/// Of float64 arithmetic with heights of a grid: as the models promise.
inline double rounding_of(const HeightGrid& grid) {
  const HeightRange range = height_range(grid);
  return 0x1p-48 * std::max(std::abs(range.lower), std::abs(range.upper));
}

/// |z - z'| of a sample by the corners of a triangle that holds it, in long doubles; negative where
/// it does not. The determinants are exact.
inline long double error_in(const delaunay::Tin& tin, std::size_t t, std::int32_t scale,
                            const HeightGrid& grid, LatticePoint sample) {
  const auto& corner = tin.triangles[t];
  const LatticePoint p{sample.x * scale, sample.y * scale};
  long double sum = 0;
  std::int64_t area = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int64_t weight = delaunay::doubled_area(p, tin.vertices[corner[(i + 1) % 3]],
                                                       tin.vertices[corner[(i + 2) % 3]]);
    if (weight < 0) return -1;
    area += weight;
    sum += static_cast<long double>(weight) * static_cast<long double>(tin.heights[corner[i]]);
  }
  return std::abs(sum / static_cast<long double>(area) - grid.height(sample.x, sample.y));
}

/// Each sample of the domain is in some triangle, and errs by no more than the tolerance, and than
/// the triangle says, in all that hold it.
inline void expect_within(const delaunay::Tin& tin, std::int32_t scale, const HeightGrid& grid,
                          double tolerance) {
  const double rounding = rounding_of(grid);
  std::vector<int> n_holding(static_cast<std::size_t>(grid.n_samples()));
  for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
    const auto at = [&](std::size_t i) { return tin.vertices[tin.triangles[t][i]]; };
    const auto [x_low, x_high] = std::minmax({at(0).x, at(1).x, at(2).x});
    const auto [y_low, y_high] = std::minmax({at(0).y, at(1).y, at(2).y});
    for (std::int32_t y = y_low / scale; y <= y_high / scale; ++y)
      for (std::int32_t x = x_low / scale; x <= x_high / scale; ++x) {
        const auto error = static_cast<double>(error_in(tin, t, scale, grid, {x, y}));
        if (error < 0) continue;
        EXPECT_TRUE(grid.has_height(x, y));
        ++n_holding[static_cast<std::size_t>(std::int64_t{y} * grid.n_columns + x)];
        EXPECT_LE(error, tolerance + rounding) << x << ", " << y;
        if (!tin.errors.empty()) EXPECT_LE(error, static_cast<double>(tin.errors[t]));
      }
  }
  for (std::int32_t y = 0; y + 1 < grid.n_rows; ++y)
    for (std::int32_t x = 0; x + 1 < grid.n_columns; ++x)
      if (delaunay::test::has_cell(grid, x, y))
        for (const LatticePoint p : {LatticePoint{x, y}, {x + 1, y}, {x, y + 1}, {x + 1, y + 1}})
          EXPECT_GT(n_holding[static_cast<std::size_t>(std::int64_t{p.y} * grid.n_columns + p.x)],
                    0);
}

/// The conditions of paper 004, section 5, and what the code says of its numbers: triangles and
/// their refinements form a forest by levels; a triangle that is refined erred beyond the level
/// that refines it, or an edge of it did, which is split then; a refinement has two triangles or
/// more; its border is the triangle's, with vertices in its edges at most; all together are fewer
/// than twice the finest mesh. With the raster that it is of errors are found again: of all samples
/// in a triangle, and where its edges cross columns and rows.
void expect_hierarchy(const Hierarchy& h, const HeightGrid* grid = nullptr);

}  // namespace lode::test
