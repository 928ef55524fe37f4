#include "lode/mappers/mesh_boundary.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/mappers/tetra_fixtures.h"

namespace lode {
namespace {

/// Six times the volume that closed triangles hold.
double six_volumes(const Surface& surface) {
  double sum = 0;
  for (const auto& [a, b, c] : surface.triangles)
    sum +=
        dot(cross(surface.world_position(a), surface.world_position(b)), surface.world_position(c));
  return sum;
}

TEST(mesh_boundary, of_a_grid_is_the_cubes_with_its_values) {
  const SimplexMesh mesh = test::grid_of(9, [](const Vec3d& p) { return p[0] + 2 * p[1]; });
  const Surface surface = mesh_boundary(mesh, {}, {2});
  EXPECT_EQ(surface.triangles.size(), 6U * 64 * 2);
  test::expect_manifold(surface);
  EXPECT_TRUE(check_topology(surface, {}).is_closed());
  EXPECT_NEAR(six_volumes(surface), 6, 1e-6);
  EXPECT_EQ(surface.errors.size(), surface.triangles.size());
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const Vec3d p = widened(surface.positions[v]);
    EXPECT_EQ(surface.values[v], p[0] + 2 * p[1]);
  }
}

TEST(mesh_boundary, is_the_same_for_any_number_of_threads) {
  const SimplexMesh mesh = test::noise(20);
  const Surface one = mesh_boundary(mesh, {}, {1});
  const Surface three = mesh_boundary(mesh, {}, {3});
  EXPECT_EQ(one.positions, three.positions);
  EXPECT_EQ(one.triangles, three.triangles);
}

TEST(mesh_boundary, of_one_tetrahedron_is_its_faces_turned_outward) {
  for (const Vec3d& origin : {Vec3d(), Vec3d{{1e8, -1e8, 0}}}) {
    SimplexMesh mesh = test::one_tetrahedron();
    for (Vec3d& p : mesh.positions) p = p + origin;
    const Surface surface = mesh_boundary(mesh, origin, {});
    EXPECT_EQ(surface.triangles.size(), 4U);
    EXPECT_TRUE(check_topology(surface, {}).is_closed());
    Surface moved = surface;
    moved.origin = {};
    EXPECT_DOUBLE_EQ(six_volumes(moved), 1);
    EXPECT_EQ(surface.errors, std::vector<float>(4, 0.25F));
  }
  EXPECT_TRUE(mesh_boundary(SimplexMesh(), {}, {}).is_empty());
}

TEST(mesh_boundary, leaves_out_faces_of_more_than_two_cells) {
  SimplexMesh mesh = test::one_tetrahedron();
  mesh.positions.push_back({{1, 1, -1}});
  mesh.positions.push_back({{0, 0, -1}});
  mesh.values = {0, 1, 2, 3, 4, 5};
  mesh.tetrahedra.push_back({0, 2, 1, 4});
  mesh.tetrahedra.push_back({0, 2, 1, 5});
  mesh.errors = {0, 0, 0};
  EXPECT_EQ(mesh_boundary(mesh, {}, {}).triangles.size(), 9U);
}

TEST(keep_regions, keeps_their_cells_and_what_belongs_to_their_vertices) {
  SimplexMesh mesh = test::grid_of(5, [](const Vec3d& p) { return p[2]; });
  for (const auto& cell : mesh.tetrahedra) {
    double z = 0;
    for (const std::uint32_t v : cell) z += mesh.positions[v][2] / 4;
    mesh.regions.push_back(z < 0.25 ? -7 : z < 0.5 ? 3 : 12);
  }
  std::vector<std::uint32_t> ids;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) ids.push_back(v + 100);
  SimplexMesh part = mesh;
  EXPECT_EQ(keep_regions(part, std::vector<std::int64_t>{-7, 12}, ids), 96U);
  EXPECT_EQ(part.tetrahedra.size(), 288U);
  EXPECT_EQ(part.regions.size(), 288U);
  EXPECT_EQ(std::ranges::count(part.regions, 3), 0);
  ASSERT_EQ(ids.size(), part.positions.size());
  for (std::size_t v = 0; v < ids.size(); ++v)
    EXPECT_EQ(part.positions[v], mesh.positions[ids[v] - 100]);
}

TEST(keep_cells_within, keeps_those_whose_corners_all_are) {
  const SimplexMesh mesh = test::grid_of(5, [](const Vec3d& p) { return p[2]; });
  SimplexMesh part = mesh;
  std::vector<std::uint32_t> ids;
  // Two of four layers; samples at the ends are within.
  EXPECT_EQ(keep_cells_within(part, 0.25, 0.75, ids), 192U);
  EXPECT_EQ(part.tetrahedra.size(), 192U);
  EXPECT_EQ(part.errors.size(), 192U);
  EXPECT_EQ(part.positions.size(), 75U);
  EXPECT_EQ(std::ranges::min(part.values), 0.25);
  EXPECT_EQ(std::ranges::max(part.values), 0.75);
  EXPECT_NEAR(six_volumes(mesh_boundary(part, {}, {})), 3, 1e-6);
  SimplexMesh all = mesh;
  EXPECT_EQ(keep_cells_within(all, 0, 1, ids), 0U);
  EXPECT_EQ(all.tetrahedra, mesh.tetrahedra);
  SimplexMesh none = mesh;
  EXPECT_EQ(keep_cells_within(none, 0.3, 0.7, ids), 384U);
  EXPECT_TRUE(none.is_empty());
  EXPECT_TRUE(none.positions.empty());
}

}  // namespace
}  // namespace lode
