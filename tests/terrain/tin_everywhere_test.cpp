// Bounds of TINs that hold between samples.
#include "lode/mappers/tin_everywhere.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "lode/api/terrain_sight.h"
#include "lode/delaunay/full_tin.h"
#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/delaunay_selector/selector.h"
#include "tests/terrain/hierarchy_fixtures.h"

namespace lode {
namespace {

using delaunay::Tin;
using Spot = Vec<double, 2>;

double area_of(const Spot& a, const Spot& b, const Spot& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// A triangle's height at a place in it, or nothing beside it.
std::optional<double> height_in(const Tin& tin, std::size_t t, double scale, const Spot& at) {
  std::array<Spot, 3> p{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& v = tin.vertices[tin.triangles[t][i]];
    p[i] = {{v.x / scale, v.y / scale}};
  }
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double weight = area_of(at, p[(i + 1) % 3], p[(i + 2) % 3]);
    if (weight < -1e-12) return std::nullopt;
    sum += weight * tin.heights[tin.triangles[t][i]];
  }
  return sum / area_of(p[0], p[1], p[2]);
}

/// The surface of all samples, its triangles by cell.
class FullOracle {
 public:
  explicit FullOracle(const HeightGrid& grid)
      : tin_(delaunay::to_full_tin(grid)->tin), n_columns_(grid.n_columns) {
    cells_.resize(static_cast<std::size_t>(grid.n_samples()));
    for (std::size_t t = 0; t < tin_.triangles.size(); ++t) {
      delaunay::LatticePoint low = tin_.vertices[tin_.triangles[t][0]];
      for (const std::uint32_t v : tin_.triangles[t])
        low = {std::min(low.x, tin_.vertices[v].x), std::min(low.y, tin_.vertices[v].y)};
      cells_[place(low.x, low.y)].push_back(t);
    }
  }
  [[nodiscard]] double height(const Spot& at) const {
    const auto x = static_cast<std::int32_t>(std::floor(at[0]));
    const auto y = static_cast<std::int32_t>(std::floor(at[1]));
    for (const std::int32_t dy : {0, -1, 1})
      for (const std::int32_t dx : {0, -1, 1}) {
        if (x + dx < 0 || y + dy < 0 || place(x + dx, y + dy) >= cells_.size()) continue;
        for (const std::size_t t : cells_[place(x + dx, y + dy)])
          if (const auto z = height_in(tin_, t, 1, at)) return *z;
      }
    ADD_FAILURE() << "no triangle holds " << at[0] << ", " << at[1];
    return 0;
  }

 private:
  [[nodiscard]] std::size_t place(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(n_columns_) +
           static_cast<std::size_t>(x);
  }
  Tin tin_;
  std::int32_t n_columns_;
  std::vector<std::vector<std::size_t>> cells_;
};

/// At places in all triangles, many of them on edges: no difference is above the bound.
void expect_bounds(const Tin& tin, const HeightGrid& grid, std::int32_t scale,
                   oracles::Random& random) {
  const FullOracle full(grid);
  for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
    double largest = 0;
    for (int k = 0; k < 100; ++k) {
      std::array<double, 3> w{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
      if (k % 2 == 0) w[static_cast<std::size_t>(k / 2 % 3)] = 0;
      const double sum = w[0] + w[1] + w[2];
      Spot at{{0, 0}};
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& v = tin.vertices[tin.triangles[t][i]];
        at[0] += w[i] / sum * v.x / scale;
        at[1] += w[i] / sum * v.y / scale;
      }
      const auto z = height_in(tin, t, scale, at);
      if (z) largest = std::max(largest, std::abs(*z - full.height(at)));
    }
    EXPECT_LE(largest, static_cast<double>(tin.errors[t]) + 1e-9) << t;
  }
}

TEST(tin_everywhere, bounds_the_selectors_triangles_between_samples) {
  oracles::Random random(11);
  for (const test::TerrainCase& c : test::terrain_cases())
    for (const double max_error : {150.0, 7.0}) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << max_error);
      Progress progress;
      auto made = delaunay_selector::select_samples(
          c.grid, {.max_error = max_error, .links = delaunay::TinLinks::kept}, progress);
      ASSERT_TRUE(made);
      const std::vector<float> at_samples = made->tin.errors;
      ASSERT_TRUE(raise_errors_everywhere(c.grid, 1, {2}, progress, made->tin));
      for (std::size_t t = 0; t < at_samples.size(); ++t)
        EXPECT_GE(made->tin.errors[t], at_samples[t]);
      Tin again = made->tin;
      ASSERT_TRUE(raise_errors_everywhere(c.grid, 1, {1}, progress, again));
      EXPECT_EQ(again.errors, made->tin.errors);
      expect_bounds(made->tin, c.grid, 1, random);
    }
}

TEST(tin_everywhere, bounds_triangles_whose_corners_lie_between_samples) {
  oracles::Random random(12);
  const std::vector<double> levels{150, 7};
  for (const test::TerrainCase& c : test::terrain_cases()) {
    SCOPED_TRACE(c.name);
    Progress progress;
    const auto made = adaptive_triangulation::build(c.grid, levels, {2}, progress);
    ASSERT_TRUE(made);
    Tin tin = tin_of_level(made->hierarchy, 1, delaunay::TinLinks::kept);
    ASSERT_TRUE(raise_errors_everywhere(c.grid, made->hierarchy.scale(), {2}, progress, tin));
    expect_bounds(tin, c.grid, made->hierarchy.scale(), random);
  }
}

/// A wall of one column, which an edge between its neighbours passes over.
TEST(tin_everywhere, sees_what_stands_between_samples_of_a_triangle) {
  const HeightGrid grid = test::make_grid<float>(9, 2, [](int x, int y) {
    return x == 4 ? 100 : y == 0 && x == 0 ? 1 : 0;
  });
  Tin tin;
  tin.vertices = {{0, 0}, {8, 0}, {0, 1}, {8, 1}};
  tin.heights = {1, 0, 0, 0};
  tin.triangles = {{0, 1, 2}, {1, 3, 2}};
  tin.errors = {1, 1};  // A lie, at samples as well.
  Progress progress;
  ASSERT_TRUE(raise_errors_everywhere(grid, 1, {1}, progress, tin));
  for (const float error : tin.errors) EXPECT_NEAR(error, 100, 1);
  progress.cancel();
  EXPECT_FALSE(raise_errors_everywhere(grid, 1, {1}, progress, tin));
}

/// Full resolution, by its own lines of sight, is never said to be other than it is.
TEST(tin_everywhere, makes_verdicts_of_sight_true) {
  const auto hills = test::make_grid<float>(60, 50, test::hills_with_spikes);
  const auto grid = std::make_shared<const HeightGrid>(hills);
  oracles::Random random(13);
  Progress progress;
  int n_decided = 0;
  for (int k = 0; k < 200; ++k) {
    const TerrainSightOptions way{.from = {{random.uniform(1, 58), random.uniform(1, 48)}},
                                  .to = {{random.uniform(1, 58), random.uniform(1, 48)}},
                                  .observer_height = random.uniform(0, 300),
                                  .target_height = random.uniform(0, 300),
                                  .vertical_metres = 0.001};
    const auto truth = find_terrain_sight(Terrain(grid), {.max_error = 0}, {}, way, progress);
    ASSERT_TRUE(truth);
    for (const double max_error : {10.0, 100.0}) {
      const auto told = find_terrain_sight(Terrain(grid), {.max_error = max_error, .samples = grid},
                                           {}, way, progress);
      ASSERT_TRUE(told);
      EXPECT_TRUE(told->terrain.is_everywhere);
      if (told->verdict == SightVerdict::undecided || truth->verdict == SightVerdict::undecided)
        continue;
      ++n_decided;
      EXPECT_EQ(told->verdict, truth->verdict);
    }
  }
  EXPECT_GT(n_decided, 50);
}

}  // namespace
}  // namespace lode
