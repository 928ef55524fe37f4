// Cubes that keep within a distance of the tetrahedra they stand for, both ways.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lode/api/dataset.h"
#include "lode/mappers/self_intersections.h"
#include "lode/models/diamond/cell_field.h"
#include "lode/models/diamond/cube_meter.h"
#include "tests/mappers/distance_oracle.h"
#include "tests/models/cube_fixtures.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using test::dataset_of;
using test::pieces_of;
using test::styled;

/// What cubes give that keep within a distance of the tetrahedra: their share of triangles.
double expect_near(const Volume& volume, double isovalue, double distance) {
  SCOPED_TRACE(distance);
  const Dataset dataset = dataset_of(volume);
  const ExtractOptions options{.isovalues = {isovalue},
                               .max_error = 0.0,
                               .style = SurfaceStyle::cubes,
                               .style_distance = distance,
                               .threads = {2}};
  Progress progress;
  Surface cubes;
  EXPECT_TRUE(dataset.extract(options, cubes, progress));
  const Surface tetra = styled(dataset, isovalue, SurfaceStyle::tetra);
  const TopologyReport found = check_topology(cubes, {});
  EXPECT_TRUE(found.is_clean_manifold());
  EXPECT_EQ(pieces_of(found), pieces_of(check_topology(tetra, {})));
  EXPECT_EQ(check_self_intersections(cubes, {2}, progress)->n_intersections, 0U);
  constexpr int kPoints = 4;
  constexpr double kRounding = 1e-5;
  EXPECT_LE(test::one_sided_distance(cubes, tetra, kPoints), distance + kRounding);
  EXPECT_LE(test::one_sided_distance(tetra, cubes, kPoints), distance + kRounding);
  return static_cast<double>(cubes.triangles.size()) / static_cast<double>(tetra.triangles.size());
}

TEST(cube_distance, keeps_tetrahedra_where_cubes_would_be_farther_than_a_distance) {
  RegularGrid grid;
  grid.dims = {{15, 16, 14}};
  grid.spacing = {{0.5, 1.0, 0.75}};
  const double s = std::sqrt(0.5);
  grid.direction = {{Vec3d{{s, -s, 0.2}}, Vec3d{{s, s, 0}}, Vec3d{{0, 0, 1}}}};
  const Volume sphere = oracles::volume_of<float>(grid, [](const Index3& p) {
    return std::hypot(p[0] - 7.3, p[1] - 7.2, p[2] - 6.9) + 0.6 * std::sin(1.1 * p[0] + p[1]);
  });
  std::vector<double> shares;
  for (const double distance : {2.0, 0.3, 0.1, 0.05, 0.02, 1e-6})
    shares.push_back(expect_near(sphere, 5.1, distance));
  EXPECT_NEAR(shares[0], 1 / 3.0, 0.03);
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_GT(shares[3], shares[0] + 0.1);
  EXPECT_GT(shares.back(), 0.95);
}

TEST(cube_distance, keeps_tetrahedra_on_noise_too) {
  RegularGrid grid;
  grid.dims = oracles::trials<Index3>({{12, 34, 7}}, {{6, 34, 3}});
  for (const std::uint32_t n_values : {3U, 1000U}) {
    std::mt19937 random(n_values);
    const Volume volume = oracles::volume_of<float>(
        grid, [&](const Index3&) { return static_cast<double>(random() % n_values); });
    for (const double distance : {0.5, 0.3, 0.15})
      expect_near(volume, n_values / 2.0 + 0.25, distance);
  }
}

/// Single cells of all cases: what is taken for near is, and most that is near is taken for it.
TEST(cube_distance, tells_of_single_cells_how_far_cubes_are) {
  RegularGrid grid;
  grid.dims = {{2, 2, 2}};
  grid.spacing = {{1, 0.8, 1.2}};
  oracles::Random random(5);
  int n_cells = 0;
  int n_close = 0;
  for (int i = 0; i < oracles::trials(20'000, 500); ++i) {
    // Some where the margin moves vertices from corners with about the isovalue.
    const bool is_far = i % 3 == 0;
    grid.origin = is_far ? Vec3d{{2100, 2100, 2100}} : Vec3d{};
    const Volume volume = oracles::volume_of<float>(grid, [&](const Index3&) {
      const double value = random.uniform(-1, 1);
      return is_far && random.below(3) == 0 ? 1e-3 * value : value;
    });
    const Dataset dataset = dataset_of(volume);
    const Surface tetra = styled(dataset, 0, SurfaceStyle::tetra);
    const Surface cube = styled(dataset, 0, SurfaceStyle::cubes);
    if (tetra.triangles.empty()) continue;
    constexpr int kPoints = 7;
    const double found = std::max(test::one_sided_distance(tetra, cube, kPoints),
                                  test::one_sided_distance(cube, tetra, kPoints));
    diamond::CubeMeter meter(LatticeFrame::of(grid), 0);
    const diamond::VolumeSamples samples(volume);
    double below = 0;
    double near = 3;
    for (int step = 0; step < 30; ++step) {
      const double middle = 0.5 * (below + near);
      const bool exceeds = meter.exceeds(samples, {{0, 0, 0}}, {.distance = middle});
      (exceeds ? below : near) = middle;
    }
    ASSERT_LE(found, near + 4 * LatticeFrame::of(grid).rounding) << i;
    ++n_cells;
    if (near <= 2 * found + 0.05) ++n_close;
  }
  EXPECT_GT(n_close, n_cells * 3 / 4);
}

TEST(cube_distance, a_distance_is_one_of_cubes_and_positive) {
  RegularGrid grid;
  grid.dims = {{5, 6, 4}};
  const Dataset dataset = dataset_of(
      oracles::volume_of<float>(grid, [](const Index3& p) { return static_cast<double>(p[0]); }));
  Progress progress;
  Surface surface;
  EXPECT_FALSE(dataset.extract({.isovalues = {2.5}, .style_distance = 0.5}, surface, progress));
  for (const double distance : {0.0, -1.0, std::nan("")})
    EXPECT_FALSE(dataset.extract(
        {.isovalues = {2.5}, .style = SurfaceStyle::cubes, .style_distance = distance}, surface,
        progress));
}

}  // namespace
}  // namespace lode
