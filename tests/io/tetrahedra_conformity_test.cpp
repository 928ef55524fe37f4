#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/io/mixed_mesh.h"
#include "tests/io/tetra_checks.h"

namespace lode::io {
namespace {

using test::MixedMesh;
using test::MixedOptions;

class mixed_meshes : public testing::TestWithParam<std::uint64_t> {};

TEST_P(mixed_meshes, become_conforming_tetrahedra) {
  const MixedOptions options{.seed = GetParam()};
  const CellMesh mesh = MixedMesh(options).mesh();
  const TetrahedraOutcome outcome = test::tetrahedra_of(mesh);
  test::expect_conforming(outcome.mesh, options.n);
  EXPECT_EQ(outcome.report.n_cells, mesh.n_cells());
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  EXPECT_EQ(outcome.report.n_zero_volume, 0U);
  EXPECT_EQ(outcome.report.n_left_handed, 0U);
  EXPECT_EQ(outcome.report.n_turned_wedges, 0U);
  EXPECT_EQ(outcome.report.n_components, 1U);
  EXPECT_EQ(outcome.report.n_unused_points, 0U);
  // The centres of polyhedra have the field's value too, since it is linear.
  const TetraMesh& result = outcome.mesh;
  for (std::size_t i = 0; i < result.positions.size(); ++i) {
    const Vec3d& p = result.positions[i];
    ASSERT_NEAR(result.fields[0].values[i], 3 * p[0] - 2 * p[1] + p[2] + 1, 1e-13);
  }
}

TEST_P(mixed_meshes, of_turned_wedges_become_conforming_tetrahedra) {
  const MixedOptions options{.seed = GetParam(), .has_turned_wedges = true};
  const TetrahedraOutcome outcome = test::tetrahedra_of(MixedMesh(options).mesh());
  test::expect_conforming(outcome.mesh, options.n);
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  EXPECT_GT(outcome.report.n_turned_wedges, 0U);
}

TEST_P(mixed_meshes, that_are_mirrored_are_turned_round) {
  const MixedOptions options{.seed = GetParam(), .is_mirrored = true};
  const TetrahedraOutcome outcome = test::tetrahedra_of(MixedMesh(options).mesh());
  test::expect_conforming(outcome.mesh, options.n);
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  EXPECT_GT(outcome.report.n_left_handed, 0U);
}

INSTANTIATE_TEST_SUITE_P(seeds, mixed_meshes, testing::Range(std::uint64_t{1}, std::uint64_t{13}));

TEST(single_hexahedron, becomes_5_or_6_tetrahedra_that_fill_it_whatever_its_ids) {
  std::array<std::uint32_t, 8> ids = {0, 1, 2, 3, 4, 5, 6, 7};
  const std::array<Vec3d, 8> cube = {{{{0, 0, 0}},
                                      {{1, 0, 0}},
                                      {{1, 1, 0}},
                                      {{0, 1, 0}},
                                      {{0, 0, 1}},
                                      {{1, 0, 1}},
                                      {{1, 1, 1}},
                                      {{0, 1, 1}}}};
  std::array<std::size_t, 2> counts{};
  do {
    CellMesh mesh = test::empty_cells();
    mesh.points.resize(8);
    for (std::size_t i = 0; i < 8; ++i) mesh.points[ids[i]] = cube[i];
    test::add_cell(mesh, CellType::hexahedron, {ids.begin(), ids.end()});
    const TetraMesh result = test::tetrahedra_of(std::move(mesh)).mesh;
    const std::size_t n = result.tetrahedra.size();
    ASSERT_TRUE(n == 5 || n == 6);
    ++counts[n - 5];
    double volume = 0;
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_GT(test::volume_of(result, i), 0.1);
      volume += test::volume_of(result, i);
    }
    ASSERT_NEAR(volume, 1, 1e-14);
    for (const auto& [face, count] : test::count_faces(result))
      ASSERT_EQ(count, test::is_in_hull(result, face, 1) ? 1 : 2);
  } while (std::next_permutation(ids.begin(), ids.begin() + 7));
  EXPECT_GT(counts[0], 0U);
  EXPECT_GT(counts[1], counts[0]);
}

}  // namespace
}  // namespace lode::io
