#include "lode/locate/plane_locator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/locate/tin_fixtures.h"

namespace lode::test {
namespace {

using PlaneTriangle = PlaneLocator::Triangle;

void expect_all_found(const std::vector<Point>& vertices,
                      const std::vector<PlaneTriangle>& triangles,
                      const std::vector<Point>& places) {
  const PlaneLocator locator(vertices, triangles);
  std::size_t n = 0;
  for (const Point& p : places) {
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      const auto& [a, b, c] = triangles[t];
      if (delaunay::orientation(vertices[a], vertices[b], p) >= 0 &&
          delaunay::orientation(vertices[b], vertices[c], p) >= 0 &&
          delaunay::orientation(vertices[c], vertices[a], p) >= 0)
        wanted.push_back(t);
    }
    std::vector<std::uint32_t> found;
    locator.visit(p, [&](std::uint32_t t) { found.push_back(t); });
    ASSERT_EQ(found, wanted) << p[0] << ' ' << p[1];
    n += found.size();
  }
  EXPECT_GT(n, places.size() / 4);
}

TEST(plane_locator, finds_all_triangles_that_hold_a_place_in_bent_tins) {
  for (const GridTin& one : all_tins()) {
    const auto bend = [](const Point& p) {
      return Point{
          {5e5 + 30.1 * p[0] + 0.01 * p[0] * p[1], 4e6 + 29.7 * p[1] - 0.02 * p[0] * p[0]}};
    };
    std::vector<Point> vertices;
    for (const LatticePoint& p : one.tin.vertices)
      vertices.push_back(bend({{static_cast<double>(p.x), static_cast<double>(p.y)}}));
    std::vector<PlaneTriangle> triangles;
    for (const auto& [a, b, c] : one.tin.triangles)
      if (delaunay::orientation(vertices[a], vertices[b], vertices[c]) > 0)
        triangles.push_back({a, b, c});
    std::vector<Point> places = vertices;
    for (std::size_t i = 0; i < 300 && i < triangles.size(); ++i) {
      const auto& [a, b, c] = triangles[i];
      places.push_back((vertices[a] + vertices[b]) * 0.5);
      places.push_back((vertices[a] + vertices[b] + vertices[c]) * (1.0 / 3));
    }
    places.resize(std::min<std::size_t>(places.size(), 1500));
    places.push_back({{0, 0}});
    places.push_back({{1e300, -1e300}});
    expect_all_found(vertices, triangles, places);
  }
}

TEST(plane_locator, finds_triangles_that_overlap_are_thin_or_are_far_larger_than_others) {
  oracles::Random random(11);
  std::vector<Point> vertices;
  std::vector<PlaneTriangle> triangles;
  const auto number = [&] { return random.uniform(-1, 1); };
  for (std::uint32_t i = 0; i < 400; ++i) {
    const double size = std::pow(10, -4 * std::abs(number()));
    const Point at{{number(), number()}};
    for (int k = 0; k < 3; ++k) vertices.push_back(at + Point{{number(), number()}} * size);
    if (i % 3 == 0) vertices.back() = vertices[3 * i] + Point{{1e-9 * number(), size}};
    PlaneTriangle t{3 * i, 3 * i + 1, 3 * i + 2};
    const int turn = delaunay::orientation(vertices[t[0]], vertices[t[1]], vertices[t[2]]);
    if (turn < 0) std::swap(t[1], t[2]);
    if (turn != 0) triangles.push_back(t);
  }
  std::vector<Point> places = vertices;
  for (int i = 0; i < 2000; ++i) places.push_back({{2 * number(), 2 * number()}});
  expect_all_found(vertices, triangles, places);
}

/// A fine grid of triangles in the corner of a coarse one, thousands of times as large.
TEST(plane_locator, looks_at_few_triangles_where_they_crowd) {
  oracles::Random random(13);
  std::vector<Point> vertices;
  std::vector<PlaneTriangle> triangles;
  const auto add_grid = [&](double left, double side, std::uint32_t n) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (std::uint32_t i = 0; i <= n; ++i)
      for (std::uint32_t k = 0; k <= n; ++k)
        vertices.push_back({{left + side * k / n, 4e6 + side * i / n}});
    for (std::uint32_t i = 0; i < n; ++i)
      for (std::uint32_t k = 0; k < n; ++k) {
        const std::uint32_t at = first + i * (n + 1) + k;
        triangles.push_back({at, at + 1, at + n + 1});
        triangles.push_back({at + 1, at + n + 2, at + n + 1});
      }
  };
  add_grid(5e5, 100, 60);
  add_grid(5e5 + 1e6, 1, 40);
  add_grid(5e5 + 100, 1e6, 3);
  const PlaneLocator locator(vertices, triangles);
  std::vector<Point> places;
  std::size_t most = 0;
  for (int i = 0; i < 3000; ++i) {
    const double side = i % 3 == 0 ? 100 : i % 3 == 1 ? 1 : 1e6;
    const double left = i % 3 == 0 ? 5e5 : i % 3 == 1 ? 1.5e6 : 5e5 + 100;
    places.push_back({{left + side * random.uniform(0, 1), 4e6 + side * random.uniform(0, 1)}});
    most = std::max(most, locator.triangles_near(places.back()).size());
  }
  EXPECT_LT(most, 200U) << "of " << triangles.size();
  places.resize(900);
  expect_all_found(vertices, triangles, places);
}

}  // namespace
}  // namespace lode::test
