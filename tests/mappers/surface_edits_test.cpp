#include "lode/mappers/surface_edits.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <vector>

#include "tests/mappers/shape_surfaces.h"

namespace lode {
namespace {

using test::point;

/// Three pairs of triangles that share an edge, all round vertex 0; the pairs take turns.
Surface make_three_fans() {
  Surface surface;
  for (int i = 0; i < 10; ++i) surface.positions.push_back(point(i, i * i, 0));
  surface.isovalues.resize(10);
  std::iota(surface.isovalues.begin(), surface.isovalues.end(), 0.0F);
  surface.triangles = {{1, 2, 0}, {0, 4, 5}, {8, 0, 7}, {0, 2, 3}, {5, 6, 0}, {9, 0, 8}};
  return surface;
}

TEST(surface_edits, gives_each_fan_its_own_vertex) {
  Surface surface = make_three_fans();
  split_pinched_vertices(surface);
  const std::vector<std::array<std::uint32_t, 3>> expected = {
      {{1, 2, 0}}, {{10, 4, 5}}, {{8, 11, 7}}, {{0, 2, 3}}, {{5, 6, 10}}, {{9, 11, 8}}};
  EXPECT_EQ(surface.triangles, expected);
  ASSERT_EQ(surface.positions.size(), 12U);
  EXPECT_EQ(surface.positions[10], surface.positions[0]);
  EXPECT_EQ(surface.positions[11], surface.positions[0]);
  ASSERT_EQ(surface.isovalues.size(), 12U);
  EXPECT_EQ(surface.isovalues[10], surface.isovalues[0]);
}

TEST(surface_edits, leaves_manifolds_alone) {
  for (Surface surface :
       {test::make_sphere(7, 1.0, {{0, 0, 0}}), test::make_torus(9, 5, 2.0, 0.5)}) {
    const auto before = surface.triangles;
    split_pinched_vertices(surface);
    EXPECT_EQ(surface.triangles, before);
  }
}

TEST(surface_edits, drops_pieces_below_a_size_and_counts_them) {
  Surface surface = test::make_torus(9, 5, 2.0, 0.5);
  const auto torus = surface.triangles;
  const std::size_t n_vertices = surface.positions.size();
  test::append(surface, test::make_sphere(3, 0.1, {{5, 0, 0}}));
  test::append(surface, test::make_sphere(3, 0.1, {{7, 0, 0}}));
  const auto all = surface.triangles;
  const std::size_t n_of_sphere = (all.size() - torus.size()) / 2;
  EXPECT_EQ(drop_small_components(surface, n_of_sphere).components, 0U);
  EXPECT_EQ(surface.triangles, all);
  const Dropped dropped = drop_small_components(surface, n_of_sphere + 1);
  EXPECT_EQ(dropped.components, 2U);
  EXPECT_EQ(dropped.cells, 2 * n_of_sphere);
  EXPECT_EQ(surface.triangles, torus);
  EXPECT_EQ(surface.positions.size(), n_vertices);
}

TEST(surface_edits, flipping_turns_triangles_and_normals) {
  Surface surface = test::make_sphere(5, 1.0, {{0, 0, 0}});
  surface.normals = surface.positions;
  const Surface before = surface;
  flip_orientation(surface);
  for (std::size_t v = 0; v < surface.normals.size(); ++v)
    EXPECT_EQ(surface.normals[v], before.normals[v] * -1.0F);
  EXPECT_NE(surface.triangles, before.triangles);
  flip_orientation(surface);
  EXPECT_EQ(surface.triangles, before.triangles);
  EXPECT_EQ(surface.normals, before.normals);
}

}  // namespace
}  // namespace lode
