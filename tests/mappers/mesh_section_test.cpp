// Planar sections of meshes without a lattice.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lode/mappers/mesh_boundary.h"
#include "lode/mappers/section.h"
#include "tests/mappers/tetra_fixtures.h"

namespace lode {
namespace {

Surface section_of(const SimplexMesh& mesh, const SectionPlane& plane, const Vec3d& origin = {}) {
  return cut_section(
      mesh, plane, section_rounding(origin, rounding_margin(mesh.positions, origin), plane.normal));
}

/// Along a direction.
double area_of(const Surface& surface, const Vec3d& normal) {
  double sum = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3d p = surface.world_position(a);
    sum += dot(cross(surface.world_position(b) - p, surface.world_position(c) - p),
               normalized(normal)) /
           2;
  }
  return sum;
}

TEST(mesh_section, of_a_cube_is_a_manifold_of_its_area_wherever_the_plane_is) {
  const SimplexMesh mesh = test::grid_of(9, [](const Vec3d& p) { return p[0] - 3 * p[2]; });
  struct Case {
    SectionPlane plane;
    double area;
  };
  const std::vector<Case> cases{
      {{{{0.5, 0.5, 0.3}}, {{0, 0, 1}}}, 1},              // between vertices
      {{{{0.5, 0.5, 0.5}}, {{0, 0, -2}}}, 1},             // along faces
      {{{{0, 0, 1}}, {{0, 0, 1}}}, 1},                    // in the border
      {{{{0.5, 0.5, 0.5}}, {{1, -1, 0}}}, std::sqrt(2)},  // along diagonals
      {{{{1, 0, 0}}, {{1, 1, 1}}}, std::sqrt(0.75)},      // through corners
  };
  for (const auto& [plane, area] : cases) {
    const Surface section = section_of(mesh, plane);
    test::expect_manifold(section);
    EXPECT_NEAR(area_of(section, plane.normal), area, 1e-5);
    for (std::size_t v = 0; v < section.positions.size(); ++v) {
      const Vec3d p = widened(section.positions[v]);
      EXPECT_NEAR(section.values[v], p[0] - 3 * p[2], 1e-6);
    }
  }
  EXPECT_TRUE(section_of(mesh, {{{0, 0, 1.01}}, {{0, 0, 1}}}).is_empty());
}

TEST(mesh_section, of_noise_is_a_manifold) {
  const SimplexMesh mesh = test::noise(17);
  for (const Vec3d& normal : {Vec3d{{1, 2, 3}}, Vec3d{{0, 1, 1}}, Vec3d{{1, 0, 0}}})
    for (const double at : {0.25, 0.5, 0.61}) {
      const Surface section = section_of(mesh, {{{at, at, at}}, normal});
      EXPECT_FALSE(section.is_empty());
      test::expect_manifold(section);
    }
}

TEST(mesh_section, of_one_tetrahedron_is_a_triangle_a_quadrilateral_a_face_or_nothing) {
  const SimplexMesh mesh = test::one_tetrahedron();
  EXPECT_EQ(section_of(mesh, {{{0, 0, 0.5}}, {{0, 0, 1}}}).triangles.size(), 1U);
  EXPECT_EQ(section_of(mesh, {{{0.25, 0.25, 0}}, {{1, 1, 0}}}).triangles.size(), 2U);
  const Surface face = section_of(mesh, {{{0, 0, 0}}, {{0, 0, 1}}});
  EXPECT_EQ(face.triangles.size(), 1U);
  EXPECT_EQ(face.values, (std::vector<double>{1, 2, 3}));
  EXPECT_TRUE(section_of(mesh, {{{0, 0, 1}}, {{0, 0, 1}}}).is_empty());  // a vertex
  EXPECT_TRUE(section_of(mesh, {{{0, 0, 0}}, {{0, 1, 1}}}).is_empty());  // an edge
  EXPECT_TRUE(section_of(SimplexMesh(), {{{0, 0, 0}}, {{0, 1, 1}}}).is_empty());
}

TEST(mesh_section, is_a_manifold_far_away) {
  SimplexMesh mesh = test::noise(9);
  for (Vec3d& p : mesh.positions) p = p + Vec3d{{1e8, -1e8, 1e8}};
  const Vec3d origin = mesh.positions.front();
  const Surface section = section_of(mesh, {origin + Vec3d{{0.4, 0.5, 0.3}}, {{1, 2, 3}}}, origin);
  EXPECT_FALSE(section.is_empty());
  test::expect_manifold(section);
}

/// Beside x = 1/2, where faces of cells lie, each cell has the region of its side.
TEST(mesh_section, and_other_surfaces_have_the_regions_of_their_cells) {
  SimplexMesh mesh = test::noise(9);
  for (const auto& cell : mesh.tetrahedra) {
    double x = 0;
    for (const std::uint32_t v : cell) x += mesh.positions[v][0] / 4;
    mesh.regions.push_back(x < 0.5 ? -7 : 40);
  }
  const auto expect_regions = [](const Surface& surface, const auto& cells) {
    ASSERT_FALSE(cells.empty());
    ASSERT_EQ(surface.regions.size(), cells.size());
    std::size_t n_left = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      double x = 0;
      for (const std::uint32_t v : cells[i]) x += surface.world_position(v)[0];
      x /= static_cast<double>(cells[i].size());
      if (std::abs(x - 0.5) < 1e-4) continue;
      EXPECT_EQ(surface.regions[i], x < 0.5 ? -7 : 40);
      n_left += x < 0.5 ? 1 : 0;
    }
    EXPECT_GT(n_left, 0U);
    EXPECT_LT(n_left, cells.size());
  };
  const Surface section = section_of(mesh, {{{0.5, 0.5, 0.5}}, {{0, 0, 1}}});
  expect_regions(section, section.triangles);
  Surface lines;
  add_isolines(section, 0.1, 1e-6, lines);
  expect_regions(lines, lines.lines);
  const Surface boundary = mesh_boundary(mesh, {}, {2});
  expect_regions(boundary, boundary.triangles);
  Surface several = test::isosurface_of(mesh, 0.1);
  add_isosurface(mesh, -0.1, {.margin = rounding_margin(mesh.positions, {}), .threads = {2}},
                 several);
  expect_regions(several, several.triangles);
}

}  // namespace
}  // namespace lode
