#include "lode/mappers/creases.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "tests/mappers/shape_surfaces.h"

namespace lode::test {
namespace {

constexpr double kRightAngle = std::numbers::pi / 2;

/// Of [0, 1]^3, twelve triangles that share eight vertices, oriented outward.
Surface make_cube() {
  Surface surface;
  for (int i = 0; i < 8; ++i) surface.positions.push_back(point(i & 1, i >> 1 & 1, i >> 2));
  for (const auto& [a, b, c, d] : std::initializer_list<std::array<std::uint32_t, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    surface.triangles.push_back({a, b, c});
    surface.triangles.push_back({a, c, d});
  }
  return surface;
}

TEST(creases, give_each_side_of_a_cube_its_own_corners) {
  Surface cube = make_cube();
  const auto before = cube.triangles;
  const auto copies = split_at_creases(cube.positions, kRightAngle - 0.01, cube.triangles);
  EXPECT_EQ(copies.size(), 6 * 4 - 8);
  const auto original = [&](std::uint32_t v) { return v < 8 ? v : copies.at(v - 8); };
  std::set<std::uint32_t> all;
  for (std::size_t side = 0; side < 6; ++side) {
    std::set<std::uint32_t> corners;
    for (std::size_t t = 2 * side; t < 2 * side + 2; ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(original(cube.triangles[t][i]), before[t][i]);
        corners.insert(cube.triangles[t][i]);
      }
    EXPECT_EQ(corners.size(), 4);
    all.insert(corners.begin(), corners.end());
  }
  EXPECT_EQ(all.size(), 24);
}

TEST(creases, are_only_where_it_turns_by_more) {
  Surface cube = make_cube();
  const auto before = cube.triangles;
  EXPECT_TRUE(split_at_creases(cube.positions, kRightAngle + 0.01, cube.triangles).empty());
  EXPECT_EQ(cube.triangles, before);
  Surface sphere = make_sphere(20, 2, {{1, 2, 3}});
  EXPECT_TRUE(split_at_creases(sphere.positions, 0.3, sphere.triangles).empty());
}

/// What lies side by side at a vertex without an edge in common is apart there, and so is what
/// runs through an edge in the same direction, or is more than two.
TEST(creases, are_where_it_is_no_oriented_manifold) {
  std::vector<Vec3f> positions{point(0, 0, 0), point(1, 0, 0), point(0, 1, 0), point(-1, 0, 0),
                               point(0, -1, 0)};
  std::vector<std::array<std::uint32_t, 3>> bow{{0, 1, 2}, {0, 3, 4}};
  EXPECT_EQ(split_at_creases(positions, 1, bow), std::vector<std::uint32_t>{0});
  std::vector<std::array<std::uint32_t, 3>> turned{{0, 1, 2}, {0, 3, 2}};
  EXPECT_EQ(split_at_creases(positions, 4, turned).size(), 2);
  std::vector<std::array<std::uint32_t, 3>> three{{0, 1, 2}, {2, 3, 0}, {0, 2, 4}};
  EXPECT_EQ(split_at_creases(positions, 4, three).size(), 4);
}

TEST(creases, are_not_at_triangles_without_area) {
  const std::vector<Vec3f> positions{point(0, 0, 0), point(1, 0, 0), point(0, 1, 0), point(1, 1, 0),
                                     point(0.5, 0.5, 0)};
  std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}, {1, 4, 2}, {1, 3, 4}, {4, 3, 2}};
  EXPECT_TRUE(split_at_creases(positions, 0.1, triangles).empty());
  std::vector<std::array<std::uint32_t, 3>> none;
  EXPECT_TRUE(split_at_creases({}, 0.1, none).empty());
}

}  // namespace
}  // namespace lode::test
