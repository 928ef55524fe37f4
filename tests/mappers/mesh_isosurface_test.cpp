#include "lode/mappers/mesh_isosurface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <vector>

#include "tests/mappers/tetra_fixtures.h"
#include "tests/oracles/random.h"

namespace lode {
namespace {

using oracles::sorted_triangles;
using test::expect_manifold;
using test::grid_of;
using test::isosurface_of;
using test::noise;

/// The same mesh with other numbers: vertices, cells and corners by turns that keep orientation.
SimplexMesh shuffled(const SimplexMesh& mesh) {
  oracles::Random random(7);
  const auto order_of = [&](std::size_t n) {
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0U);
    for (std::size_t i = n; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
    return order;
  };
  const std::vector<std::uint32_t> vertices = order_of(mesh.positions.size());
  SimplexMesh made = mesh;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    made.positions[vertices[v]] = mesh.positions[v];
    made.values[vertices[v]] = mesh.values[v];
  }
  std::size_t at = 0;
  for (const std::uint32_t cell : order_of(mesh.tetrahedra.size())) {
    auto corners = mesh.tetrahedra[cell];
    if (random.below(2) == 0) corners = {corners[1], corners[0], corners[3], corners[2]};
    const auto n_turns = static_cast<std::ptrdiff_t>(random.below(3));
    std::rotate(corners.begin(), corners.begin() + n_turns, corners.end() - 1);
    for (std::uint32_t& v : corners) v = vertices[v];
    made.tetrahedra[at++] = corners;
  }
  return made;
}

TEST(mesh_isosurface, is_a_manifold_that_ends_at_the_meshs_boundary) {
  const SimplexMesh mesh = noise(28);
  const Surface surface = isosurface_of(mesh, 0.02);
  ASSERT_GT(surface.triangles.size(), 20000U);
  expect_manifold(surface);
  for (const auto& [a, b] : find_boundary_edges(surface, {2})) {
    const Vec3f& p = surface.positions[a];
    EXPECT_TRUE(std::ranges::any_of(p.v, [](float x) { return x == 0 || x == 1; }));
  }
}

TEST(mesh_isosurface, is_the_same_for_any_number_of_threads) {
  const SimplexMesh mesh = noise(28);
  const Surface one = isosurface_of(mesh, 0.02, {1});
  for (const int n : {2, 3, 8}) {
    const Surface other = isosurface_of(mesh, 0.02, {n});
    EXPECT_EQ(one.positions, other.positions);
    EXPECT_EQ(one.triangles, other.triangles);
    EXPECT_EQ(one.isovalues, other.isovalues);
  }
}

TEST(mesh_isosurface, does_not_depend_on_how_the_mesh_is_numbered) {
  const SimplexMesh mesh = noise(20);
  for (const double isovalue : {-0.2, 0.0, 0.11})
    EXPECT_EQ(sorted_triangles(isosurface_of(mesh, isovalue)),
              sorted_triangles(isosurface_of(shuffled(mesh), isovalue)));
}

TEST(mesh_isosurface, needs_no_cell_that_it_does_not_cross) {
  const SimplexMesh mesh = noise(20);
  SimplexMesh part = mesh;
  std::erase_if(part.tetrahedra, [&](const auto& t) {
    return std::ranges::none_of(t, [&](std::uint32_t v) { return mesh.values[v] >= 0; }) ||
           std::ranges::all_of(t, [&](std::uint32_t v) { return mesh.values[v] >= 0; });
  });
  ASSERT_LT(part.tetrahedra.size(), mesh.tetrahedra.size());
  EXPECT_EQ(sorted_triangles(isosurface_of(part, 0)), sorted_triangles(isosurface_of(mesh, 0)));
}

TEST(mesh_isosurface, is_a_manifold_through_vertices_edges_and_faces) {
  const auto steps = [](const Vec3d& p) { return p[0] + p[1] + p[2]; };
  const SimplexMesh slanted = grid_of(9, steps);
  const SimplexMesh flat = grid_of(9, [](const Vec3d& p) { return p[2]; });
  for (const SimplexMesh* mesh : {&slanted, &flat})
    for (const double isovalue : {0.125, 0.5, 0.75}) {
      const Surface surface = isosurface_of(*mesh, isovalue);
      EXPECT_FALSE(surface.is_empty());
      expect_manifold(surface);
    }
}

TEST(mesh_isosurface, is_empty_at_and_below_the_least_value_and_above_the_largest) {
  const SimplexMesh mesh = grid_of(9, [](const Vec3d& p) { return p[0] * p[1]; });
  EXPECT_TRUE(isosurface_of(mesh, 0).is_empty());
  EXPECT_TRUE(isosurface_of(mesh, -1).is_empty());
  EXPECT_TRUE(isosurface_of(mesh, 1.001).is_empty());
  const Surface corner = isosurface_of(mesh, 1);  // round the edge where x = y = 1
  EXPECT_FALSE(corner.is_empty());
  expect_manifold(corner);
  const SimplexMesh constant = grid_of(5, [](const Vec3d&) { return 3.0; });
  for (const double isovalue : {2.0, 3.0, 4.0})
    EXPECT_TRUE(isosurface_of(constant, isovalue).is_empty());
  EXPECT_TRUE(isosurface_of(SimplexMesh(), 1).is_empty());
}

TEST(mesh_isosurface, of_one_tetrahedron_faces_lower_values) {
  SimplexMesh mesh = test::one_tetrahedron();
  for (unsigned inside = 1; inside < 15; ++inside) {
    mesh.values.clear();
    for (unsigned i = 0; i < 4; ++i) mesh.values.push_back((inside >> i & 1) != 0 ? 1 : -1);
    Surface surface;
    EXPECT_EQ(add_isosurface(mesh, 0, {}, surface), 0.25);
    const bool is_quad = std::popcount(inside) == 2;
    ASSERT_EQ(surface.triangles.size(), is_quad ? 2U : 1U);
    EXPECT_EQ(surface.positions.size(), is_quad ? 4U : 3U);
    const Vec3d slope{{mesh.values[1] - mesh.values[0], mesh.values[2] - mesh.values[0],
                       mesh.values[3] - mesh.values[0]}};
    for (const auto& [a, b, c] : surface.triangles) {
      const Vec3f normal = cross(surface.positions[b] - surface.positions[a],
                                 surface.positions[c] - surface.positions[a]);
      EXPECT_LT(dot(widened(normal), slope), 0);
    }
  }
}

TEST(mesh_isosurface, of_several_isovalues_are_appended) {
  const SimplexMesh mesh = noise(12);
  Surface both = isosurface_of(mesh, 0.1);
  const Surface first = both;
  const Surface second = isosurface_of(mesh, -0.1);
  add_isosurface(mesh, -0.1, {.margin = rounding_margin(mesh.positions, {}), .threads = {2}}, both);
  ASSERT_EQ(both.positions.size(), first.positions.size() + second.positions.size());
  EXPECT_EQ(both.isovalues.front(), 0.1);
  EXPECT_EQ(both.isovalues.back(), -0.1);
  const auto n = static_cast<std::uint32_t>(first.positions.size());
  for (std::size_t i = 0; i < second.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(both.triangles[first.triangles.size() + i][k], n + second.triangles[i][k]);
}

TEST(mesh_isosurface, stays_a_manifold_far_away_and_in_thin_cells) {
  SimplexMesh mesh = noise(12);
  for (Vec3d& p : mesh.positions) p = Vec3d{{1e8 + p[0], -1e8 + 1e-4 * p[1], p[2]}};
  const Surface surface = isosurface_of(mesh, 0.02, {2}, mesh.positions.front());
  ASSERT_FALSE(surface.is_empty());
  expect_manifold(surface);
}

TEST(mesh_isosurface, crosses_edges_between_the_largest_values_there_are) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  SimplexMesh mesh = grid_of(3, [](const Vec3d& p) { return p[0] < 0.7 ? -kLargest : kLargest; });
  const Surface surface = isosurface_of(mesh, 0);
  ASSERT_FALSE(surface.is_empty());
  for (const Vec3f& p : surface.positions) EXPECT_FLOAT_EQ(p[0], 0.75F);
}

}  // namespace
}  // namespace lode
