// Gradients at vertices, and the normals that isosurfaces have from them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lode/mappers/mesh_gradients.h"
#include "lode/mappers/zero_normals.h"
#include "tests/mappers/tetra_fixtures.h"

namespace lode {
namespace {

Surface with_normals(const SimplexMesh& mesh, double isovalue) {
  const std::vector<Vec3f> gradients = vertex_gradients(mesh, {2});
  Surface surface;
  add_isosurface(
      mesh, isovalue,
      {.margin = rounding_margin(mesh.positions, {}), .gradients = gradients, .threads = {2}},
      surface);
  EXPECT_EQ(surface.normals.size(), surface.positions.size());
  return surface;
}

/// Degrees.
double angle_between(const Vec3f& a, const Vec3d& b) {
  const Vec3d c = widened(a);
  return std::atan2(length(cross(c, b)), dot(c, b)) * 180 / std::numbers::pi;
}

double largest_angle(const Surface& surface, const auto& expected) {
  double largest = 0;
  for (std::size_t v = 0; v < surface.positions.size(); ++v)
    largest = std::max(largest,
                       angle_between(surface.normals[v], expected(widened(surface.positions[v]))));
  return largest;
}

/// A grid that is squeezed along y, and sheared.
SimplexMesh thin_grid(const auto& value) {
  SimplexMesh mesh = test::grid_of(9, [](const Vec3d&) { return 0.0; });
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    Vec3d& p = mesh.positions[v];
    p = Vec3d{{p[0] + 0.3 * p[2], 1e-4 * p[1], p[2]}};
    mesh.values[v] = value(p);
  }
  return mesh;
}

TEST(vertex_gradients, are_those_of_a_linear_field_whatever_the_cells) {
  const Vec3d slope{{0.5, -1, 0.25}};
  const auto linear = [&](const Vec3d& p) { return dot(slope, p); };
  for (const SimplexMesh& mesh : {test::grid_of(9, linear), thin_grid(linear)})
    for (const Vec3f& g : vertex_gradients(mesh, {2}))  // as shares of the largest coordinate, 1
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(static_cast<double>(g[i]), slope[i], 1e-6);
}

/// Two cells at vertex 0, of solid angles pi / 2 and pi / 4: what a corner and half of it have.
TEST(vertex_gradients, are_weighted_by_solid_angles) {
  SimplexMesh mesh;
  mesh.positions = {Vec3d{{0, 0, 0}}, Vec3d{{1, 0, 0}}, Vec3d{{0, 1, 0}}, Vec3d{{0, 0, 1}},
                    Vec3d{{-1, 1, 0}}};
  mesh.values = {0, 8, 0, 0, -8};
  mesh.tetrahedra = {{0, 1, 2, 3}, {0, 2, 4, 3}};
  mesh.errors = {0, 0};
  EXPECT_EQ(vertex_gradients(mesh, {})[0], (Vec3f{{1, 0, 0}}));
  mesh.values[4] = 4;  // slopes of 8 and -4, two parts and one
  const std::vector<Vec3f> gradients = vertex_gradients(mesh, {});
  EXPECT_FLOAT_EQ(gradients[1][0], 1);
  EXPECT_FLOAT_EQ(gradients[0][0], 0.5);
  EXPECT_FLOAT_EQ(gradients[4][0], -0.5);
}

TEST(vertex_gradients, are_the_same_for_any_number_of_threads) {
  const SimplexMesh mesh = test::noise(16);
  EXPECT_EQ(vertex_gradients(mesh, {1}), vertex_gradients(mesh, {3}));
}

TEST(vertex_gradients, leave_out_cells_without_volume) {
  SimplexMesh mesh = test::one_tetrahedron();
  mesh.positions.push_back({{0.5, 0.5, 0}});
  mesh.values = {0, 1, 0, 0, 100};
  mesh.tetrahedra.push_back({0, 1, 4, 2});
  mesh.tetrahedra.push_back({0, 1, 1, 2});
  mesh.errors = {0, 0, 0};
  const std::vector<Vec3f> gradients = vertex_gradients(mesh, {});
  EXPECT_EQ(gradients[0], (Vec3f{{1, 0, 0}}));
  EXPECT_EQ(gradients[4], Vec3f());
  EXPECT_TRUE(vertex_gradients(SimplexMesh(), {}).empty());
}

TEST(mesh_normals, of_linear_fields_are_exact_and_point_to_lower_values) {
  const Vec3d slope{{0.5, -1, 0.25}};
  const auto linear = [&](const Vec3d& p) { return dot(slope, p); };
  const auto down = [&](const Vec3d&) { return slope * -1.0; };
  // Coordinates of normals are off by 2^-25, and gradients' by as much: 5e-6 degrees.
  EXPECT_LT(largest_angle(with_normals(test::grid_of(9, linear), 0.1), down), 2e-5);
  EXPECT_LT(largest_angle(with_normals(thin_grid(linear), 0.3), down), 2e-5);
}

TEST(mesh_normals, of_a_sphere_are_within_two_degrees_and_halve_with_the_cells) {
  const Vec3d centre{{0.5, 0.5, 0.5}};
  const auto distance = [&](const Vec3d& p) { return length(p - centre); };
  const auto inward = [&](const Vec3d& p) { return centre - p; };
  const Surface coarse = with_normals(test::grid_of(17, distance), 0.3);
  const Surface fine = with_normals(test::grid_of(33, distance), 0.3);
  ASSERT_GT(coarse.triangles.size(), 1000U);
  const double angle = largest_angle(coarse, inward);
  EXPECT_LT(angle, 2);
  EXPECT_LT(largest_angle(fine, inward), 0.6 * angle);
}

TEST(mesh_normals, where_gradients_cancel_are_the_triangles) {
  const SimplexMesh mesh = test::one_tetrahedron();
  const std::vector<Vec3f> none(4);
  Surface surface;
  add_isosurface(mesh, 1.5, {.gradients = none}, surface);
  ASSERT_EQ(surface.normals, std::vector<Vec3f>(3));
  fill_zero_normals(surface, {});
  const Vec3d slope{{1, 2, 3}};
  for (const Vec3f& n : surface.normals) EXPECT_LT(angle_between(n, slope * -1.0), 1e-4);
}

TEST(mesh_normals, between_cells_of_opposite_slopes_cancel) {
  SimplexMesh mesh;
  mesh.positions = {Vec3d{{0, 0, 0}}, Vec3d{{0, 1, 0}}, Vec3d{{0, 0, 1}}, Vec3d{{1, 0, 0}},
                    Vec3d{{-1, 0, 0}}};
  mesh.values = {0, 0, 0, 1, 1};  // |x|
  mesh.tetrahedra = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  mesh.errors = {0, 0};
  const std::vector<Vec3f> gradients = vertex_gradients(mesh, {});
  EXPECT_EQ(gradients[0], Vec3f());
  EXPECT_EQ(gradients[3], (Vec3f{{1, 0, 0}}));
  EXPECT_EQ(gradients[4], (Vec3f{{-1, 0, 0}}));
}

}  // namespace
}  // namespace lode
