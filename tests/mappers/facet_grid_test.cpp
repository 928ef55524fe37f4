// The nearest of many facets, whatever their shapes.

#include "lode/mappers/facet_grid.h"

#include <gtest/gtest.h>

#include "lode/mappers/facet_proof.h"
#include "tests/mappers/distance_oracle.h"
#include "tests/oracles/random.h"

namespace lode {
namespace {

/// In a box of 16^3 voxels, each about as large as one.
std::vector<Facet> facets_in(const Vec3d& voxel, std::size_t n) {
  oracles::Random random(3);
  std::vector<Facet> facets(n);
  for (Facet& facet : facets) {
    Vec3d middle;
    for (double& x : middle.v) x = random.uniform(0, 16);
    for (Vec3f& corner : facet.corner)
      for (std::size_t i = 0; i < 3; ++i)
        corner[i] = static_cast<float>((middle[i] + random.uniform(0, 1)) * voxel[i]);
  }
  return facets;
}

class facet_grid : public testing::TestWithParam<Vec3d> {};

TEST_P(facet_grid, finds_the_nearest_within_a_limit) {
  const Vec3d& voxel = GetParam();
  const std::vector<Facet> facets = facets_in(voxel, 500);
  oracles::Random random(4);
  for (const double reach : {0.01, 1.0, 30.0}) {
    const FacetGrid grid(facets, reach);
    for (int i = 0; i < 100; ++i) {
      Vec3d p;
      for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = random.uniform(-2, 19) * voxel[axis];
      double nearest = std::numeric_limits<double>::infinity();
      for (const Facet& facet : facets)
        nearest = std::min(nearest, test::triangle_distance(p, corners_of(facet)));
      const auto found = grid.find(p, {.limit = reach});
      const double rounding = 1e-9 * (1 + length(p));
      EXPECT_EQ(found.facet != FacetGrid::kNone, nearest <= reach);
      if (found.facet == FacetGrid::kNone) continue;
      EXPECT_NEAR(std::sqrt(found.squared_distance), nearest, rounding);
      EXPECT_NEAR(test::triangle_distance(p, corners_of(facets[found.facet])), nearest, rounding);
    }
  }
}

/// Else a facet is in thousands of cells, or a cell has thousands of them.
TEST_P(facet_grid, has_few_entries_for_each_facet) {
  const std::vector<Facet> facets = facets_in(GetParam(), 20'000);
  const FacetGrid grid(facets, 1e-6);
  EXPECT_LT(grid.n_entries(), 40 * facets.size());
  EXPECT_LT(grid.n_most_in_cell(), 100U);
}

INSTANTIATE_TEST_SUITE_P(voxels, facet_grid,
                         testing::Values(Vec3d{{1, 1, 1}}, Vec3d{{1, 1, 100}}, Vec3d{{0.01, 1, 1}},
                                         Vec3d{{0.001, 1, 1000}}));

/// A triangle 90 long and 1 wide above a plane of small ones: pieces as long as wide are enough.
TEST(facet_proof, cuts_long_triangles_into_few_pieces) {
  std::vector<Facet> plane;
  for (int x = -1; x <= 90; ++x)
    for (int y = -1; y <= 1; ++y) {
      const auto at = [&](int i, int j) {
        return Vec3f{{static_cast<float>(x + i), static_cast<float>(y + j), 0}};
      };
      plane.push_back({{at(0, 0), at(1, 0), at(0, 1)}});
      plane.push_back({{at(1, 0), at(1, 1), at(0, 1)}});
    }
  const FacetGrid grid(plane, 1);
  const Facet needle{{Vec3f{{0, 0, 0.5F}}, Vec3f{{90, 0, 0.5F}}, Vec3f{{90, 1, 0.5F}}}};
  const FacetProof proof = prove_near(needle, grid, {.limit = 1, .n_most_pieces = 2500});
  EXPECT_TRUE(proof.holds);
  EXPECT_GE(proof.bound, 0.5);
  EXPECT_LE(proof.bound, 1);
}

}  // namespace
}  // namespace lode
