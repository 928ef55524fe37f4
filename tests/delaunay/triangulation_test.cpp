#include "lode/delaunay/triangulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "tests/oracles/random.h"

namespace lode::delaunay {
namespace {

using Edge = std::array<std::uint32_t, 2>;

double area_of(const std::vector<Point>& points, const std::array<std::uint32_t, 3>& t) {
  const Point u = points[t[1]] - points[t[0]];
  const Point v = points[t[2]] - points[t[0]];
  return 0.5 * (u[0] * v[1] - u[1] * v[0]);
}

/// Twice the signed area that directed edges enclose.
double enclosed(const std::vector<Point>& points, const std::vector<Edge>& edges) {
  double sum = 0;
  for (const Edge& e : edges)
    sum += points[e[0]][0] * points[e[1]][1] - points[e[0]][1] * points[e[1]][0];
  return 0.5 * sum;
}

/// Positive triangles, each inner edge used once each way, the boundary exactly `edges`, and the
/// area theirs: together that leaves no gap and no overlap.
void expect_fills(const std::vector<Point>& points, const std::vector<Edge>& edges,
                  const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::set<Edge> directed;
  double area = 0;
  for (const auto& t : triangles) {
    EXPECT_GT(orientation(points[t[0]], points[t[1]], points[t[2]]), 0);
    area += area_of(points, t);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(directed.insert({t[i], t[(i + 1) % 3]}).second);
  }
  std::set<Edge> boundary;
  for (const Edge& e : directed)
    if (!directed.contains({e[1], e[0]})) boundary.insert(e);
  EXPECT_EQ(boundary, std::set<Edge>(edges.begin(), edges.end()));
  EXPECT_NEAR(area, enclosed(points, edges), 1e-9 * (1 + std::abs(area)));
}

/// No circle of two neighbouring triangles contains the other's corner, but across fixed edges.
void expect_delaunay(const Triangulation& triangulation) {
  const auto& points = triangulation.points();
  for (const Triangle& t : triangulation.triangles())
    for (std::size_t i = 0; i < 3; ++i) {
      if (t.neighbour[i] == kNone || t.is_fixed[i]) continue;
      for (const std::uint32_t corner : triangulation.triangles()[t.neighbour[i]].corner)
        EXPECT_LE(side_of_circle(points[t.corner[0]], points[t.corner[1]], points[t.corner[2]],
                                 points[corner]),
                  0);
    }
}

TEST(triangulation, of_random_points_is_delaunay_and_fills_their_hull) {
  oracles::Random random(7);
  for (int round = 0; round < 40; ++round) {
    std::vector<Point> points;
    for (int i = 0; i < 3 + 10 * round; ++i)
      points.push_back({{random.uniform(0, 1), random.uniform(0, 1)}});
    const auto triangulation = Triangulation::of(points);
    ASSERT_TRUE(triangulation);
    expect_delaunay(*triangulation);
    std::set<std::uint32_t> used;
    for (const Triangle& t : triangulation->triangles())
      used.insert(t.corner.begin(), t.corner.end());
    EXPECT_EQ(used.size(), points.size());
  }
}

TEST(triangulation, of_a_lattice_has_two_triangles_a_square) {
  std::vector<Point> points;
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 7; ++x) points.push_back({{double(x), double(y)}});
  const auto triangulation = Triangulation::of(points);
  ASSERT_TRUE(triangulation);
  EXPECT_EQ(triangulation->triangles().size(), 2U * 6 * 8);
  expect_delaunay(*triangulation);
}

TEST(triangulation, of_points_on_one_line_is_empty_and_of_equal_points_fails) {
  const auto line = Triangulation::of({{{0, 0}}, {{2, 1}}, {{4, 2}}});
  ASSERT_TRUE(line);
  EXPECT_TRUE(line->triangles().empty());
  const auto twice = Triangulation::of({{{0, 0}}, {{2, 1}}, {{0, 0}}});
  ASSERT_FALSE(twice);
  EXPECT_NE(twice.error().message.find("points 0 and 2"), std::string::npos)
      << twice.error().message;
}

TEST(triangulation, keeps_edges_that_cross_hundreds_of_others) {
  oracles::Random random(3);
  std::vector<Point> points{{{-1, 0.5}}, {{2, 0.500001}}, {{0.5, -1}}, {{0.5000003, 0.499}}};
  for (int i = 0; i < 2000; ++i) points.push_back({{random.uniform(0, 1), random.uniform(0, 1)}});
  auto triangulation = Triangulation::of(points);
  ASSERT_TRUE(triangulation);
  ASSERT_TRUE(triangulation->fix_edge(0, 1));
  ASSERT_TRUE(triangulation->fix_edge(2, 3));
  expect_delaunay(*triangulation);
  const auto crossing = triangulation->fix_edge(4, 2);
  for (int i = 5; i < 50; ++i) {
    const auto done = triangulation->fix_edge(4, static_cast<std::uint32_t>(i));
    const bool is_above = points[4][1] > 0.5;
    if (!done)
      EXPECT_NE(is_above, points[static_cast<std::size_t>(i)][1] > 0.5) << done.error().message;
  }
}

/// A star-shaped ring round (x, y), counter-clockwise or not.
void add_ring(std::vector<Point>& points, std::vector<Edge>& edges, double x, double y, double r,
              int n, bool is_left, oracles::Random& random) {
  const auto first = static_cast<std::uint32_t>(points.size());
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    const double radius = r * random.uniform(0.5, 1);
    points.push_back({{x + radius * std::cos(angle), y + radius * std::sin(angle)}});
    const auto a = first + static_cast<std::uint32_t>(i);
    const auto b = first + static_cast<std::uint32_t>((i + 1) % n);
    edges.push_back(is_left ? Edge{a, b} : Edge{b, a});
  }
}

TEST(region, of_rings_with_holes_and_islands_is_filled) {
  oracles::Random random(11);
  for (int round = 0; round < 60; ++round) {
    std::vector<Point> points;
    std::vector<Edge> edges;
    const int n = 3 + 5 * round;
    add_ring(points, edges, 0, 0, 20, 4 * n, true, random);
    for (int k = 0; k < 4; ++k) {
      const double angle = std::numbers::pi / 2 * k;
      add_ring(points, edges, 5 * std::cos(angle), 5 * std::sin(angle), 3, n, false, random);
      add_ring(points, edges, 5 * std::cos(angle), 5 * std::sin(angle), 1.4, n, true, random);
    }
    const auto triangles = triangulate_region(points, edges);
    ASSERT_TRUE(triangles) << triangles.error().message;
    expect_fills(points, edges, *triangles);
    EXPECT_EQ(triangles->size(), static_cast<std::size_t>(8 * n + 6 + 4 * (n - 2)));
  }
}

TEST(region, of_lattice_squares_is_filled_whatever_lies_on_one_line_or_circle) {
  oracles::Random random(5);
  constexpr int kSide = 12;
  const auto id = [](int x, int y) { return static_cast<std::uint32_t>(y * (kSide + 1) + x); };
  for (int round = 0; round < 60; ++round) {
    std::map<std::array<int, 2>, bool> is_in;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) is_in[{x, y}] = random.uniform(0, 1) < 0.6;
    std::vector<Point> points;
    for (int y = 0; y <= kSide; ++y)
      for (int x = 0; x <= kSide; ++x) points.push_back({{double(x), double(y)}});
    std::vector<Edge> edges;
    const auto inside = [&](int x, int y) {
      const auto at = is_in.find({x, y});
      return at != is_in.end() && at->second;
    };
    for (int y = 0; y <= kSide; ++y)
      for (int x = 0; x <= kSide; ++x) {
        if (inside(x, y) && !inside(x, y - 1)) edges.push_back({id(x, y), id(x + 1, y)});
        if (!inside(x, y) && inside(x, y - 1)) edges.push_back({id(x + 1, y), id(x, y)});
        if (inside(x, y) && !inside(x - 1, y)) edges.push_back({id(x, y + 1), id(x, y)});
        if (!inside(x, y) && inside(x - 1, y)) edges.push_back({id(x, y), id(x, y + 1)});
      }
    const auto triangles = triangulate_region(points, edges);
    ASSERT_TRUE(triangles) << triangles.error().message;
    expect_fills(points, edges, *triangles);
  }
}

TEST(region, with_edges_that_cross_or_do_not_close_fails_with_their_points) {
  const std::vector<Point> square{{{0, 0}}, {{4, 0}}, {{4, 4}}, {{0, 4}}, {{2, 2}}};
  const std::vector<Edge> cross{{0, 2}, {1, 3}};
  EXPECT_FALSE(triangulate_region(square, cross));
  const std::vector<Edge> open{{0, 1}, {1, 2}, {2, 3}};
  EXPECT_FALSE(triangulate_region(square, open));
  const std::vector<Edge> clockwise{{0, 3}, {3, 2}, {2, 1}, {1, 0}};
  EXPECT_FALSE(triangulate_region(square, clockwise));
  const std::vector<Edge> through{{0, 2}, {2, 3}, {3, 0}};
  const auto done = triangulate_region(square, through);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("point 4"), std::string::npos) << done.error().message;
}

}  // namespace
}  // namespace lode::delaunay
