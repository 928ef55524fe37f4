#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "lode/delaunay/convex_hull.h"
#include "lode/delaunay/lattice_side.h"
#include "lode/delaunay/point_insertion.h"
#include "lode/delaunay/tin.h"
#include "lode/delaunay/triangulation.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/random.h"

namespace lode::delaunay::test {

/// Scattered points in rows, with heights.
struct Points {
  std::vector<LatticePoint> nodes;
  std::vector<double> heights;

  [[nodiscard]] HeightRange range() const {
    const auto [lower, upper] = std::ranges::minmax(heights);
    return {lower, upper};
  }
};

/// Sorted, each node once, with heights by a rule z(x, y).
template <typename Rule>
Points make_points(const std::vector<LatticePoint>& nodes, const Rule& rule) {
  std::set<std::pair<std::int32_t, std::int32_t>> sorted;
  for (const LatticePoint& p : nodes) sorted.insert({p.y, p.x});
  Points points;
  for (const auto& [y, x] : sorted) {
    points.nodes.push_back({x, y});
    points.heights.push_back(rule(x, y));
  }
  return points;
}

inline std::vector<LatticePoint> random_nodes(int n, std::int32_t size, std::uint64_t seed) {
  oracles::Random random(seed);
  std::vector<LatticePoint> nodes;
  for (int i = 0; i < n; ++i)
    nodes.push_back({static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(size))),
                     static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(size)))});
  return nodes;
}

/// Twice the area of the convex hull, by gift wrapping.
inline Int128 doubled_hull_area(const std::vector<LatticePoint>& nodes) {
  const auto below = [](LatticePoint a, LatticePoint b) {
    return std::pair(a.y, a.x) < std::pair(b.y, b.x);
  };
  const LatticePoint first = *std::ranges::min_element(nodes, below);
  LatticePoint at = first;
  Int128 area = 0;
  do {
    LatticePoint next = at == nodes[0] ? nodes[1] : nodes[0];
    for (const LatticePoint& p : nodes) {
      if (p == at) continue;
      const std::int64_t side = doubled_area(at, next, p);
      const auto far = [&](LatticePoint q) {
        return std::abs(std::int64_t{q.x} - at.x) + std::abs(std::int64_t{q.y} - at.y);
      };
      if (side < 0 || (side == 0 && far(p) > far(next))) next = p;
    }
    area += Int128{at.x} * next.y - Int128{at.y} * next.x;
    at = next;
  } while (at != first);
  return area;
}

/// Positive triangles that fill the hull once: areas add up, and each edge is used once each way.
inline void expect_fills_hull(const Tin& tin, const Points& points) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  Int128 area = 0;
  for (const Corners& t : tin.triangles) {
    const std::int64_t own =
        doubled_area(tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]]);
    EXPECT_GT(own, 0);
    area += own;
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_TRUE(edges.insert({t[i], t[(i + 1) % 3]}).second) << "an edge is used twice";
  }
  EXPECT_TRUE(area == doubled_hull_area(points.nodes));
}

/// The largest vertical error of a point, by trying every triangle for every point; but for the
/// seven roundings, to 64 bits, of numbers up to the range of heights that it may be off by.
inline long double largest_error(const Tin& tin, const Points& points) {
  const auto height = [&](LatticePoint p) {
    const auto at = std::ranges::find(points.nodes, p) - points.nodes.begin();
    return static_cast<long double>(points.heights[static_cast<std::size_t>(at)]);
  };
  std::vector<long double> z;
  for (const LatticePoint& p : tin.vertices) z.push_back(height(p));
  long double largest = 0;
  for (std::size_t i = 0; i < points.nodes.size(); ++i) {
    const LatticePoint p = points.nodes[i];
    bool is_covered = false;
    for (const Corners& t : tin.triangles) {
      const LatticePoint a = tin.vertices[t[0]];
      const LatticePoint b = tin.vertices[t[1]];
      const LatticePoint c = tin.vertices[t[2]];
      const std::int64_t wa = doubled_area(b, c, p);
      const std::int64_t wb = doubled_area(c, a, p);
      const std::int64_t wc = doubled_area(a, b, p);
      if (wa < 0 || wb < 0 || wc < 0) continue;
      is_covered = true;
      const long double way = (static_cast<long double>(wb) * (z[t[1]] - z[t[0]]) +
                               static_cast<long double>(wc) * (z[t[2]] - z[t[0]])) /
                              static_cast<long double>(doubled_area(a, b, c));
      largest = std::max(largest, std::abs((points.heights[i] - z[t[0]]) - way));
    }
    EXPECT_TRUE(is_covered) << "a point is in no triangle";
  }
  const HeightRange range = points.range();
  return std::max(0.0L, largest - 0x1p-61L * (range.upper - range.lower));
}

/// The hull's triangulation, and each point's triangle by trying all.
struct Start {
  std::vector<Corners> triangles;
  std::vector<std::uint32_t> triangle_of;
};

inline Start start_of(const Points& points) {
  const std::vector<std::uint32_t> hull = convex_hull(points.nodes);
  std::vector<Point> places;
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::uint32_t i = 0; i < hull.size(); ++i) {
    places.push_back(to_point(points.nodes[hull[i]]));
    edges.push_back({i, i + 1 < hull.size() ? i + 1 : 0});
  }
  const auto region = triangulate_region(places, edges);
  EXPECT_TRUE(region) << region.error().message;
  Start start;
  for (const Corners& t : *region) start.triangles.push_back({hull[t[0]], hull[t[1]], hull[t[2]]});
  start.triangle_of.assign(points.nodes.size(), kNoHalfEdge);
  for (std::size_t i = 0; i < points.nodes.size(); ++i)
    for (std::uint32_t t = 0; t < start.triangles.size(); ++t) {
      const auto at = [&](std::size_t k) { return points.nodes[start.triangles[t][k]]; };
      const LatticePoint p = points.nodes[i];
      if (doubled_area(at(0), at(1), p) >= 0 && doubled_area(at(1), at(2), p) >= 0 &&
          doubled_area(at(2), at(0), p) >= 0)
        start.triangle_of[i] = t;
    }
  return start;
}

}  // namespace lode::delaunay::test
