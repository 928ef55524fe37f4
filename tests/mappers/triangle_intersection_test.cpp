#include "lode/mappers/triangle_intersection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace lode {
namespace {

using Point = Vec<std::int64_t, 3>;

Vec3f to_float(const Point& p) {
  return {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
}

bool has_gap(const std::vector<Point>& s, const std::vector<Point>& t, const Point& axis) {
  std::int64_t s_min = INT64_MAX, s_max = INT64_MIN, t_min = INT64_MAX, t_max = INT64_MIN;
  for (const Point& p : s) {
    s_min = std::min(s_min, dot(p, axis));
    s_max = std::max(s_max, dot(p, axis));
  }
  for (const Point& p : t) {
    t_min = std::min(t_min, dot(p, axis));
    t_max = std::max(t_max, dot(p, axis));
  }
  return s_max < t_min || t_max < s_min;
}

std::vector<Point> edges_of(const std::vector<Point>& s) {
  std::vector<Point> edges;
  for (std::size_t i = 0; i < s.size(); ++i) edges.push_back(s[(i + 1) % s.size()] - s[i]);
  return edges;
}

/// The oracle: two convex sets are disjoint iff some facet normal of their Minkowski difference
/// separates them; in integers this is exact.
bool meet(const std::vector<Point>& s, const std::vector<Point>& t) {
  const auto e = edges_of(s);
  const auto f = edges_of(t);
  std::vector<Point> axes;
  for (const Point& a : e)
    for (const Point& b : f) axes.push_back(cross(a, b));
  for (const auto* edges : {&e, &f}) {
    const Point normal = cross((*edges)[0], (*edges)[1]);
    axes.push_back(normal);
    for (const Point& a : e) axes.push_back(cross(normal, a));
    for (const Point& a : f) axes.push_back(cross(normal, a));
  }
  for (const Point& axis : axes)
    if (has_gap(s, t, axis)) return false;
  return true;
}

Point random_point(std::mt19937& random, std::int64_t size) {
  std::uniform_int_distribution<std::int64_t> coordinate(0, size);
  return {{coordinate(random), coordinate(random), coordinate(random)}};
}

std::vector<Point> random_triangle(std::mt19937& random, std::int64_t size) {
  while (true) {
    std::vector<Point> t = {random_point(random, size), random_point(random, size),
                            random_point(random, size)};
    if (cross(t[1] - t[0], t[2] - t[0]) != Point{}) return t;
  }
}

TriangleCorners corners(const std::vector<Point>& t) {
  return {to_float(t[0]), to_float(t[1]), to_float(t[2])};
}

TEST(triangle_intersection, agrees_with_separating_axes_on_small_lattices) {
  std::mt19937 random(7);
  int n_meeting = 0;
  for (int i = 0; i < 30000; ++i) {
    const std::int64_t size = 2 + i % 5;
    const auto s = random_triangle(random, size);
    const auto t = random_triangle(random, size);
    const bool expected = meet(s, t);
    n_meeting += expected ? 1 : 0;
    ASSERT_EQ(triangles_meet(corners(s), corners(t)), expected) << "pair " << i;
  }
  EXPECT_GT(n_meeting, 3000);
}

TEST(triangle_intersection, knows_when_a_common_corner_is_all) {
  std::mt19937 random(8);
  int n_meeting = 0;
  for (int i = 0; i < 30000; ++i) {
    const std::int64_t size = 2 + i % 4;
    auto s = random_triangle(random, size);
    auto t = random_triangle(random, size);
    for (Point& p : t) p = p + (s[0] - t[0]);
    t[0] = s[0];
    if (cross(t[1] - t[0], t[2] - t[0]) == Point{}) continue;
    const bool has_common = s[1] == t[1] || s[1] == t[2] || s[2] == t[1] || s[2] == t[2];
    if (has_common) continue;
    const bool expected = meet({s[1], s[2]}, t) || meet({t[1], t[2]}, s);
    n_meeting += expected ? 1 : 0;
    ASSERT_EQ(triangles_meet_beyond_corner(corners(s), corners(t)), expected) << "pair " << i;
  }
  EXPECT_GT(n_meeting, 2000);
}

TEST(triangle_intersection, decides_one_unit_in_the_last_place) {
  const TriangleCorners s = {Vec3f{{0, 0, 1}}, Vec3f{{4, 0, 1}}, Vec3f{{0, 4, 1}}};
  const float below = std::nextafter(1.0F, 0.0F);
  const float above = std::nextafter(1.0F, 2.0F);
  const auto spike = [](float z) {
    return TriangleCorners{Vec3f{{1, 1, z}}, Vec3f{{1, 1, 5}}, Vec3f{{2, 1, 5}}};
  };
  EXPECT_TRUE(triangles_meet(s, spike(below)));
  EXPECT_TRUE(triangles_meet(s, spike(1.0F)));
  EXPECT_FALSE(triangles_meet(s, spike(above)));
}

TEST(triangle_intersection, sees_folded_but_not_flat_or_bent_neighbours) {
  const TriangleCorners s = {Vec3f{{0, 0, 0}}, Vec3f{{1, 0, 0}}, Vec3f{{0, 1, 0}}};
  const auto with = [&](float y, float z) {
    return TriangleCorners{s[0], s[1], Vec3f{{0.25F, y, z}}};
  };
  EXPECT_TRUE(triangles_meet_beyond_edge(s, with(0.5F, 0)));
  EXPECT_FALSE(triangles_meet_beyond_edge(s, with(-0.5F, 0)));
  EXPECT_FALSE(triangles_meet_beyond_edge(s, with(0.5F, 1e-40F)));
}

TEST(triangle_intersection, tells_zero_area_from_a_sliver) {
  const Vec3f a{{1e6F, 0, 0}};
  const Vec3f b{{1e6F + 1, 1, 1}};
  EXPECT_TRUE(has_zero_area(a, b, Vec3f{{1e6F + 2, 2, 2}}));
  EXPECT_TRUE(has_zero_area(a, b, a));
  EXPECT_FALSE(has_zero_area(a, b, Vec3f{{1e6F + 2, 2, std::nextafter(2.0F, 3.0F)}}));
}

TEST(triangle_intersection, decides_lines_in_the_plane) {
  const LineEnds s = {Vec3f{{0, 0, 0}}, Vec3f{{2, 2, 0}}};
  EXPECT_TRUE(lines_meet(s, {Vec3f{{0, 2, 0}}, Vec3f{{2, 0, 0}}}));
  EXPECT_TRUE(lines_meet(s, {Vec3f{{1, 1, 0}}, Vec3f{{2, 0, 0}}}));
  EXPECT_FALSE(lines_meet(s, {Vec3f{{3, 3, 0}}, Vec3f{{4, 4, 0}}}));
  EXPECT_TRUE(lines_meet_beyond_end(s, {s[0], Vec3f{{1, 1, 0}}}));
  EXPECT_TRUE(lines_meet_beyond_end(s, {s[0], Vec3f{{3, 3, 0}}}));
  EXPECT_FALSE(lines_meet_beyond_end(s, {s[0], Vec3f{{-1, -1, 0}}}));
  EXPECT_FALSE(lines_meet_beyond_end(s, {s[0], Vec3f{{1, 0.5F, 0}}}));
}

}  // namespace
}  // namespace lode
