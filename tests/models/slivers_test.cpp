// Slivers removed: short edges collapse, and the surface stays what it is.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lode/api/dataset.h"
#include "lode/mappers/self_intersections.h"
#include "lode/mappers/surface_topology.h"
#include "tests/models/built_dataset.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

/// Triangles whose height is below a thirtieth of their longest edge.
std::size_t n_slivers(const Surface& surface) {
  std::size_t n = 0;
  for (const auto& t : surface.triangles) {
    const Vec3d a = surface.world_position(t[0]);
    const Vec3d b = surface.world_position(t[1]);
    const Vec3d c = surface.world_position(t[2]);
    const double longest = std::max({length(b - a), length(c - b), length(a - c)});
    n += length(cross(b - a, c - a)) < longest * longest / 30 ? 1 : 0;
  }
  return n;
}

struct Before {
  std::size_t n_slivers = 0;
  std::size_t n_triangles = 0;
};

/// Returns what there was before, with which `surface` is compared.
Before expect_cleaned(const Volume& volume, double isovalue, SurfaceStyle style, double distance,
                      Surface& surface) {
  const Dataset dataset = test::built_dataset(volume);
  ExtractOptions options{.isovalues = {isovalue}, .max_error = 0.0, .style = style, .threads = {2}};
  Progress progress;
  Surface before;
  EXPECT_TRUE(dataset.extract(options, before, progress));
  options.simplify_distance = distance;
  options.simplify = Simplify::slivers;
  const auto report = dataset.extract(options, surface, progress);
  EXPECT_TRUE(report) << (report ? "" : report.error().message);
  if (!report) return {};
  EXPECT_LE(report->simplified->proven_distance, distance);
  const TopologyReport expected = check_topology(before, {});
  const TopologyReport found = check_topology(surface, {});
  EXPECT_TRUE(found.is_clean_manifold());
  EXPECT_EQ(found.euler_number, expected.euler_number);
  EXPECT_EQ(found.components.size(), expected.components.size());
  EXPECT_EQ(check_self_intersections(surface, {2}, progress)->n_intersections, 0U);
  EXPECT_TRUE(dataset.verify_surface(surface, options, progress)->passed());
  return {n_slivers(before), before.triangles.size()};
}

TEST(slivers, go_and_most_triangles_stay) {
  const Volume volume = oracles::sample(oracles::Field::gaussians40, 65);
  const double voxel = volume.info.grid.spacing[0];
  for (const SurfaceStyle style : {SurfaceStyle::tetra, SurfaceStyle::cubes}) {
    Surface surface;
    const Before before = expect_cleaned(volume, 1, style, 0.2 * voxel, surface);
    EXPECT_GT(before.n_slivers, 100U);
    EXPECT_LT(n_slivers(surface), before.n_slivers / 3);
    EXPECT_GT(surface.triangles.size(), before.n_triangles / 2);
  }
}

TEST(slivers, go_from_noise_which_stays_a_manifold) {
  for (std::uint64_t seed = 1; seed <= oracles::trials(3U, 1U); ++seed) {
    RegularGrid grid;
    grid.dims = oracles::trials<Index3>({{20, 23, 17}}, {{14, 15, 12}});
    oracles::Random random(seed);
    const Volume volume =
        oracles::volume_of<float>(grid, [&](const Index3&) { return random.uniform(0, 1); });
    for (const SurfaceStyle style : {SurfaceStyle::tetra, SurfaceStyle::cubes})
      for (const double distance : {0.05, 0.3}) {
        Surface surface;
        const Before before = expect_cleaned(volume, 0.5, style, distance, surface);
        EXPECT_LT(n_slivers(surface), before.n_slivers);
      }
  }
}

}  // namespace
}  // namespace lode
