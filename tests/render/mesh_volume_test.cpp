#include "lode/render/mesh_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/render/tetra_fixtures.h"

namespace lode::test {
namespace {

/// Thin, so that lengths come back with many digits.
constexpr double kExtinction = 1e-3;
const TransferFunction kEven{{{0, {{1, 1, 1}}, kExtinction}}};

double walked_length(const VolumeProbe& probe, const Lens::Point& point) {
  return -std::log(probe.at(point).transmittance) / kExtinction;
}

/// Rays all over the picture meet as much of the mesh as brute force finds in its cells. Vertices
/// relative to a ray have 26 bits: both ends of a way through the mesh may be off by some 2^-25 of
/// a cell's size. Of transmittances lengths come with an error of 1e-16 / kExtinction.
void expect_all_lengths(const SimplexMesh& mesh, const Camera& camera) {
  constexpr double kTolerance = 1e-7;
  constexpr int kSize = 40;
  const VolumeProbe probe(mesh, kEven, camera, kSize);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  double longest = 0;
  for (int i = 0; i < 300; ++i) {
    const Lens::Point point{kSize * unit(random), kSize * unit(random)};
    const double expected = length_in_mesh(world_ray(camera, probe.lens(), point), mesh);
    EXPECT_NEAR(walked_length(probe, point), expected, kTolerance) << point.x << " " << point.y;
    longest = std::max(longest, expected);
  }
  EXPECT_GT(longest, 0.1);
}

const Camera kOblique{{{2.5, -1.9, 1.7}}, {{0.5, 0.5, 0.5}}, {{0, 0, 1}}, 35};

TEST(mesh_volume, rays_meet_the_whole_of_a_shaken_cube) {
  SimplexMesh mesh = cube_mesh(5);
  shake(mesh, 5, 1);
  expect_all_lengths(mesh, kOblique);
}

TEST(mesh_volume, rays_meet_all_of_domains_with_cavities_and_components) {
  SimplexMesh hollow = cube_mesh(6, [](const Vec3d& p) {
    return length(p - Vec3d{{0.5, 0.5, 0.5}}) > 0.3 && std::abs(p[0] - 0.75) > 0.08;
  });
  shake(hollow, 6, 2);
  expect_all_lengths(hollow, kOblique);
  std::mt19937_64 random(3);
  SimplexMesh crumbs = cube_mesh(6, [&](const Vec3d&) { return random() % 2 == 0; });
  std::erase_if(crumbs.tetrahedra, [&](const auto&) { return random() % 3 == 0; });
  shake(crumbs, 6, 3);
  expect_all_lengths(crumbs, kOblique);
}

TEST(mesh_volume, rays_from_inside_start_at_the_eye) {
  SimplexMesh mesh = cube_mesh(4);
  shake(mesh, 4, 4);
  expect_all_lengths(mesh, {{{0.41, 0.38, 0.52}}, {{0.9, 0.7, 0.6}}, {{0, 0, 1}}, 120});
  SimplexMesh hollow = cube_mesh(6, [](const Vec3d& p) {
    return length(p - Vec3d{{0.5, 0.5, 0.5}}) > 0.3;
  });
  expect_all_lengths(hollow, {{{0.51, 0.48, 0.52}}, {{0, 0.1, 0.2}}, {{0, 0, 1}}, 150});
  expect_all_lengths(hollow, {{{0.05, 0.06, 0.07}}, {{1, 0.9, 0.8}}, {{0, 0, 1}}, 90});
}

TEST(mesh_volume, far_eyes_and_small_meshes_far_from_the_origin_cost_no_accuracy) {
  SimplexMesh mesh = cube_mesh(3);
  expect_all_lengths(mesh, {{{2e6, -3e6, 1e6}}, {{0.5, 0.5, 0.5}}, {{0, 0, 1}}, 2.5e-5});
  for (Vec3d& p : mesh.positions) p = p + Vec3d{{1e6, -1e6, 3e6}};
  expect_all_lengths(
      mesh,
      {{{1e6 + 3, -1e6 - 2, 3e6 + 2}}, {{1e6 + 0.5, -1e6 + 0.5, 3e6 + 0.5}}, {{0, 0, 1}}, 30});
}

// The middle row and column of rays run in the planes of faces, the middle ray along edges.
TEST(mesh_volume, rays_along_faces_and_edges_are_not_lost) {
  const SimplexMesh mesh = cube_mesh(4);
  const Camera camera{{{0.5, -2, 0.5}}, {{0.5, 0.5, 0.5}}, {{0, 0, 1}}, 30};
  const VolumeProbe probe(mesh, kEven, camera, 33);
  for (int y = 4; y < 29; ++y) {
    for (int x = 4; x < 29; ++x) {
      const Lens::Point point{x + 0.5, y + 0.5};
      const WorldRay ray = world_ray(camera, probe.lens(), point);
      const auto slab = [&](std::size_t axis) {
        const double a = (0 - ray.eye[axis]) / ray.direction[axis];
        const double b = (1 - ray.eye[axis]) / ray.direction[axis];
        return std::pair(std::min(a, b), std::max(a, b));
      };
      double begin = 0;
      double end = 1e300;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (std::abs(ray.direction[axis]) < 1e-12) continue;
        begin = std::max(begin, slab(axis).first);
        end = std::min(end, slab(axis).second);
      }
      EXPECT_NEAR(walked_length(probe, point), std::max(0.0, end - begin), 1e-9) << x << " " << y;
    }
  }
}

TEST(mesh_volume, transmittance_of_an_even_cube_is_the_exponential_of_the_length) {
  const SimplexMesh mesh = cube_mesh(3);
  for (const double extinction : {0.1, 2.0, 9.0}) {
    const VolumeProbe probe(mesh, {{{0, {{0.5, 0.25, 1}}, extinction}}}, kOblique, 40);
    for (int i = 0; i < 40; ++i) {
      const Lens::Point point{i + 0.3, 40 - i * 0.9};
      const double expected =
          std::exp(-extinction * length_in_mesh(world_ray(kOblique, probe.lens(), point), mesh));
      const RayLight light = probe.at(point);
      EXPECT_NEAR(light.transmittance, expected, 2e-5);
      EXPECT_NEAR(light.light[0], 0.5 * (1 - expected), 2e-5);
      EXPECT_NEAR(light.light[2], 1 - expected, 2e-5);
    }
  }
}

// The field is linear over the whole cube, so what comes along a ray does not depend on the mesh.
TEST(mesh_volume, light_does_not_depend_on_how_a_linear_field_is_meshed) {
  const TransferFunction bands{{{1, {{1, 0, 0}}, 0},
                                {2, {{1, 1, 0}}, 4},
                                {2.1, {{0, 1, 0}}, 0},
                                {4, {{0, 0, 1}}, 0},
                                {4.001, {{0, 0, 1}}, 5},
                                {6, {{1, 1, 1}}, 0}}};
  const SimplexMesh coarse = cube_mesh(1);
  SimplexMesh fine = cube_mesh(7);
  shake(fine, 7, 8);
  for (std::size_t v = 0; v < fine.positions.size(); ++v)
    fine.values[v] = dot(fine.positions[v], Vec3d{{1, 2, 4}});
  const VolumeProbe a(coarse, bands, kOblique, 40);
  const VolumeProbe b(fine, bands, kOblique, 40);
  for (int i = 0; i < 400; ++i) {
    const Lens::Point point{(i % 20) * 2 + 0.7, (i / 20) * 2 + 0.4};
    const RayLight one = a.at(point);
    const RayLight other = b.at(point);
    EXPECT_NEAR(one.transmittance, other.transmittance, 2e-5);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(one.light[c], other.light[c], 4e-5);
  }
}

TEST(mesh_volume, something_opaque_ends_a_ray) {
  const SimplexMesh mesh = cube_mesh(4);
  const Camera camera{{{0.5, -2, 0.5}}, {{0.5, 0.5, 0.5}}, {{0, 0, 1}}, 30};
  const VolumeProbe probe(mesh, {{{0, {{1, 1, 1}}, 2}}}, camera, 33);
  const double scale = probe.normalization().scale;
  for (const double share : {-1.0, 0.0, 0.1, 0.25, 0.6, 0.999, 2.0}) {
    const double expected = std::exp(-2 * std::clamp(share, 0.0, 1.0));
    EXPECT_NEAR(probe.at({16.5, 16.5}, (share - 0.5) * scale).transmittance, expected, 1e-6);
  }
}

TEST(mesh_volume, flat_cells_add_nothing_and_lose_nothing) {
  SimplexMesh mesh = cube_mesh(5);
  for (Vec3d& p : mesh.positions) {
    if (std::abs(p[0] - 0.4) < 1e-9) p[0] = 0.6;  // A layer without thickness.
    if (std::abs(p[2] - 0.4) < 1e-9) p[2] = 0.6 - 1e-13;
  }
  expect_all_lengths(mesh, kOblique);
  SimplexMesh flat = cube_mesh(1);
  for (Vec3d& p : flat.positions) p[2] = 0;
  const VolumeProbe probe(flat, kEven, kOblique, 40);
  for (int i = 0; i < 40; ++i) EXPECT_NEAR(walked_length(probe, {i + 0.5, i + 0.5}), 0, 1e-9);
}

TEST(mesh_volume, one_tetrahedron_and_none_are_volumes) {
  SimplexMesh one;
  one.positions = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
  one.values = {0, 1, 2, 3};
  one.tetrahedra = {{0, 1, 2, 3}};
  expect_all_lengths(one, kOblique);
  std::swap(one.tetrahedra[0][0], one.tetrahedra[0][1]);  // Inside out.
  expect_all_lengths(one, kOblique);
  EXPECT_EQ(VolumeProbe({}, kEven, kOblique, 8).at({4, 4}).transmittance, 1);
}

TEST(mesh_volume, faces_of_more_than_two_cells_are_outer_ones) {
  SimplexMesh mesh;
  mesh.positions = {{{0, 0, 0}},     {{1, 0, 0}},      {{0, 1, 0}},
                    {{0.2, 0.2, 1}}, {{0.2, 0.2, -1}}, {{0.3, 0.3, -2}}};
  mesh.values.assign(6, 0);
  mesh.tetrahedra = {{0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 2, 5}};
  const auto volume = MeshVolume::build(mesh, {});
  ASSERT_TRUE(volume);
  EXPECT_EQ(volume->links().outer_faces.size(), 12U);
  mesh.tetrahedra.pop_back();
  EXPECT_EQ(MeshVolume::build(mesh, {})->links().outer_faces.size(), 6U);
}

TEST(mesh_volume, what_is_no_mesh_is_refused) {
  const SimplexMesh good = cube_mesh(1);
  const auto refused = [&](const auto& spoil, const char* message) {
    SimplexMesh mesh = good;
    spoil(mesh);
    const auto volume = MeshVolume::build(mesh, {});
    ASSERT_FALSE(volume) << message;
    EXPECT_NE(volume.error().message.find(message), std::string::npos) << volume.error().message;
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  refused([&](SimplexMesh& m) { m.positions[3][1] = kNan; }, "vertex 3 has nan");
  refused([&](SimplexMesh& m) { m.positions[3][1] = 1e200; }, "expected positions up to");
  refused([&](SimplexMesh& m) { m.values[2] = kNan; }, "expected values up to");
  refused([&](SimplexMesh& m) { m.values.pop_back(); }, "expected 8 values");
  refused([&](SimplexMesh& m) { m.tetrahedra[1][2] = 8; }, "tetrahedron 1 names vertex 8");
  refused([&](SimplexMesh& m) { m.tetrahedra[1][2] = m.tetrahedra[1][0]; }, "twice");
}

}  // namespace
}  // namespace lode::test
