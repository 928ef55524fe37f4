#include "lode/mappers/surface_turning.h"

#include <gtest/gtest.h>

#include <utility>

#include "tests/mappers/shape_surfaces.h"

namespace lode {
namespace {

/// Two pieces: the sphere's triangles come first.
Surface sphere_and_torus(std::uint32_t detail) {
  Surface all = test::make_sphere(detail, 1, {{9, 0, 0}});
  const Surface torus = test::make_torus(3 * detail, 2 * detail, 4, 1);
  const auto n = static_cast<std::uint32_t>(all.positions.size());
  all.positions.insert(all.positions.end(), torus.positions.begin(), torus.positions.end());
  for (const auto& t : torus.triangles) all.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  return all;
}

std::size_t n_of_sphere(std::uint32_t detail) {
  return test::make_sphere(detail, 1, {{0, 0, 0}}).triangles.size();
}

void turn(Surface& surface, std::size_t first, std::size_t end) {
  for (std::size_t t = first; t < end; ++t)
    std::swap(surface.triangles[t][1], surface.triangles[t][2]);
}

TEST(surface_turning, closed_pieces_face_outward_or_inward) {
  Surface all = sphere_and_torus(5);
  EXPECT_EQ(facing_of(all, {2}).n_outward, 2U);
  EXPECT_EQ(facing_of(all, {2}).n_open, 0U);
  turn(all, 0, n_of_sphere(5));
  EXPECT_EQ(facing_of(all, {2}).n_outward, 1U);
  EXPECT_EQ(facing_of(all, {2}).n_inward, 1U);
  // Far away, where products of coordinates would say nothing.
  all.origin = {{1e9, -3e9, 2e9}};
  EXPECT_EQ(facing_of(all, {1}).n_inward, 1U);
  all.triangles.pop_back();
  EXPECT_EQ(facing_of(all, {2}).n_open, 1U);
  // Both sides of one triangle.
  Surface flat;
  flat.positions = {test::point(0, 0, 0), test::point(1, 0, 0), test::point(0, 1, 0)};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_EQ(facing_of(flat, {1}).n_flat, 1U);
  EXPECT_EQ(facing_of({}, {1}).n_flat, 0U);
}

TEST(surface_turning, is_told_by_what_is_near) {
  const Progress progress;
  const Surface fine = sphere_and_torus(24);
  const auto facing = [&](const Surface& of, double reach = 0.2) {
    return hold_against(of, fine, reach, {2}, progress).value();
  };
  Surface coarse = sphere_and_torus(5);
  EXPECT_EQ(facing(coarse).share_turned, 0);
  EXPECT_EQ(facing(coarse).n_large_open, 0U) << "they are closed";
  Surface turned = coarse;
  turn(turned, 0, turned.triangles.size());
  EXPECT_EQ(facing(turned).share_turned, 1);
  // Both are open; the sphere is the smaller part.
  const std::size_t n = n_of_sphere(5);
  coarse.triangles.erase(coarse.triangles.begin() + static_cast<std::ptrdiff_t>(n));
  coarse.triangles.erase(coarse.triangles.begin());
  EXPECT_EQ(facing(coarse).n_large_open, 2U);
  EXPECT_EQ(facing(coarse).n_turned, 0U);
  turn(coarse, 0, n - 1);
  EXPECT_LT(facing(coarse).share_turned, 0.5);
  EXPECT_EQ(facing(coarse).n_turned, 1U);
  EXPECT_EQ(facing(coarse, 3).n_large_open, 0U) << "next to what may be off by so much";
  EXPECT_TRUE(facing(turned, 0.2).is_large);
  EXPECT_FALSE(facing(turned, 3).is_large);
  EXPECT_EQ(facing({}).share_turned, 0);
  EXPECT_EQ(hold_against(coarse, {}, 0.3, {2}, progress)->share_turned, 0);
  // However far they are from each other.
  const Surface far = test::make_sphere(4, 1, {{50, 0, 0}});
  EXPECT_TRUE(hold_against(coarse, far, 1e-3, {1}, progress));
}

}  // namespace
}  // namespace lode
