#include "lode/locate/tin_profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/locate/tin_fixtures.h"

namespace lode::test {
namespace {

struct Ends {
  Point a, b;
};

/// At random, along rows, columns and edges, through vertices, and across everything.
std::vector<Ends> hard_segments(const GridTin& one) {
  std::vector<Ends> segments;
  const std::vector<Point> places = hard_places(one, 7, 30);
  for (std::size_t i = 0; i + 7 < places.size(); ++i)
    if (places[i] != places[i + 7]) segments.push_back({places[i], places[i + 7]});
  const double columns = one.grid.n_columns - 1;
  const double rows = one.grid.n_rows - 1;
  for (const double y : {0.0, 1.0, rows, rows / 2})
    for (const double x : {-3.0, 0.0}) segments.push_back({{{x, y}}, {{columns - x, y}}});
  for (const double x : {0.0, columns, std::floor(columns / 3)})
    segments.push_back({{{x, -2}}, {{x, rows}}});
  segments.push_back({{{0, 0}}, {{columns, rows}}});
  segments.push_back({{{-5, -5}}, {{100, 100}}});
  for (std::size_t t = 0; t < one.tin.triangles.size(); t += 1 + one.tin.triangles.size() / 20) {
    const LatticePoint u = one.tin.vertices[one.tin.triangles[t][0]];
    const LatticePoint v = one.tin.vertices[one.tin.triangles[t][1]];
    segments.push_back({{{u.x + 0.0, u.y + 0.0}}, {{v.x + 0.0, v.y + 0.0}}});
    segments.push_back(
        {{{2.0 * u.x - v.x, 2.0 * u.y - v.y}}, {{2.0 * v.x - u.x, 2.0 * v.y - u.y}}});
  }
  return segments;
}

Point place_at(const Ends& s, double t) {
  return {{s.a[0] + t * (s.b[0] - s.a[0]), s.a[1] + t * (s.b[1] - s.a[1])}};
}

/// Whether the closed domain holds what lies within `reach` of p, or nothing there: 1, -1; else 0.
int side_of_domain(const HeightGrid& grid, const Point& p, double reach) {
  bool has_all = true;
  bool has_any = false;
  for (const double dx : {-reach, reach})
    for (const double dy : {-reach, reach}) {
      const bool has =
          delaunay::test::has_cell(grid, static_cast<std::int32_t>(std::floor(p[0] + dx)),
                                   static_cast<std::int32_t>(std::floor(p[1] + dy)));
      has_all = has_all && has;
      has_any = has_any || has;
    }
  return has_all ? 1 : (has_any ? 0 : -1);
}

/// A t between rows: in a part where there is terrain, in a gap where there is none.
void expect_parts_are_terrain(const GridTin& one, const Ends& s,
                              const std::vector<ProfilePoint>& points) {
  constexpr double kReach = 1e-9;  // Of places rounded, far above 2^-53 of 200.
  double before = 0;
  for (std::size_t i = 0; i <= points.size(); ++i) {
    const double after = i < points.size() ? points[i].t : 1;
    const bool is_gap = i == points.size() || points[i].starts_part;
    const Point middle = place_at(s, (before + after) / 2);
    if (after - before > 1e-7) {
      const int side = side_of_domain(one.grid, middle, kReach);
      EXPECT_TRUE(is_gap ? side < 1 : side > -1)
          << one.name << " from " << s.a[0] << ',' << s.a[1] << " to " << s.b[0] << ',' << s.b[1]
          << " at " << middle[0] << ',' << middle[1];
    }
    before = after;
  }
}

void expect_linear_between(const GridTin& one, const std::vector<ProfilePoint>& points) {
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].starts_part) continue;
    const Point middle{
        {(points[i - 1].at[0] + points[i].at[0]) / 2, (points[i - 1].at[1] + points[i].at[1]) / 2}};
    const std::uint32_t t = find_by_trying(one.tin, middle);
    if (t == one.tin.triangles.size()) continue;  // On the outline, but for rounding.
    // Slopes are below 2000 a column, places off by less than 2^-44.
    EXPECT_NEAR(plane_at(one.tin, t, middle), (points[i - 1].height + points[i].height) / 2, 1e-8)
        << one.name;
  }
}

/// Edges that the segment crosses inside of both, by CGAL's predicate.
std::size_t count_crossings(const Tin& tin, const Ends& s) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> crossed;
  const auto point = [&](std::uint32_t v) {
    return Point{{static_cast<double>(tin.vertices[v].x), static_cast<double>(tin.vertices[v].y)}};
  };
  for (const auto& t : tin.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [u, v] = std::minmax(t[i], t[(i + 1) % 3]);
      const Point p = point(u);
      const Point q = point(v);
      if (delaunay::orientation(s.a, s.b, p) * delaunay::orientation(s.a, s.b, q) < 0 &&
          delaunay::orientation(p, q, s.a) * delaunay::orientation(p, q, s.b) < 0)
        crossed.insert({u, v});
    }
  return crossed.size();
}

std::size_t count_vertices_inside(const Tin& tin, const Ends& s) {
  std::size_t n = 0;
  for (const LatticePoint& v : tin.vertices) {
    const Point p{{static_cast<double>(v.x), static_cast<double>(v.y)}};
    const double way = (p[0] - s.a[0]) * (s.b[0] - s.a[0]) + (p[1] - s.a[1]) * (s.b[1] - s.a[1]);
    const double back = (p[0] - s.b[0]) * (s.a[0] - s.b[0]) + (p[1] - s.b[1]) * (s.a[1] - s.b[1]);
    n += static_cast<std::size_t>(delaunay::orientation(s.a, s.b, p) == 0 && way > 0 && back > 0);
  }
  return n;
}

TEST(tin_profile, meets_every_edge_and_vertex_once_and_is_linear_between) {
  for (const GridTin& one : all_tins())
    for (const Ends& s : hard_segments(one)) {
      const std::vector<ProfilePoint> points = tin_profile(one.tin, s.a, s.b);
      expect_parts_are_terrain(one, s, points);
      expect_linear_between(one, points);
      EXPECT_TRUE(std::ranges::is_sorted(points, {}, &ProfilePoint::t));
      // Crossings next to an end may be rounded to its place: only one row there is the end's.
      const auto is_inside = [&](const Point& p) {
        return find_by_trying(one.tin, p) < one.tin.triangles.size();
      };
      std::size_t n_inner = points.size();
      if (!points.empty() && points.front().at == s.a && is_inside(s.a)) --n_inner;
      if (!points.empty() && points.back().at == s.b && is_inside(s.b)) --n_inner;
      // Vertices that are only touched have no row.
      const std::size_t n_crossings = count_crossings(one.tin, s);
      EXPECT_GE(n_inner, n_crossings) << one.name;
      EXPECT_LE(n_inner, n_crossings + count_vertices_inside(one.tin, s)) << one.name;
    }
}

TEST(tin_profile, is_the_same_backwards) {
  for (const GridTin& one : all_tins())
    for (const Ends& s : hard_segments(one)) {
      const std::vector<ProfilePoint> there = tin_profile(one.tin, s.a, s.b);
      const std::vector<ProfilePoint> back = tin_profile(one.tin, s.b, s.a);
      ASSERT_EQ(there.size(), back.size()) << one.name;
      for (std::size_t i = 0; i < there.size(); ++i) {
        const ProfilePoint& other = back[back.size() - 1 - i];
        EXPECT_NEAR(there[i].t, 1 - other.t, 1e-12);
        EXPECT_NEAR(there[i].height, other.height, 1e-8);
      }
    }
}

TEST(tin_profile, runs_along_the_outline_in_both_directions) {
  const GridTin one = select_tin("hills", make_grid<std::int16_t>(50, 40, hilly), 40);
  for (const Ends& s : {Ends{{{0, 0}}, {{49, 0}}}, Ends{{{49, 0}}, {{0, 0}}},
                        Ends{{{0, 39}}, {{49, 39}}}, Ends{{{49, 3}}, {{49, 31}}}}) {
    const std::vector<ProfilePoint> points = tin_profile(one.tin, s.a, s.b);
    ASSERT_GE(points.size(), 2U);
    EXPECT_EQ(points.front().at, s.a);
    EXPECT_EQ(points.back().at, s.b);
    for (std::size_t i = 1; i < points.size(); ++i) EXPECT_FALSE(points[i].starts_part);
  }
  EXPECT_TRUE(tin_profile(one.tin, {{-1, -1}}, {{60, -1}}).empty());
  EXPECT_TRUE(tin_profile(one.tin, {{-1, 1}}, {{1, -1}}).empty()) << "touches a corner";
}

TEST(tin_profile, of_a_plane_is_straight) {
  const auto plane = [](std::int32_t x, std::int32_t y) { return 2 * x - 3 * y + 100; };
  const GridTin one = select_tin("plane", make_grid<std::int16_t>(20, 20, plane), 0);
  const std::vector<ProfilePoint> points = tin_profile(one.tin, {{1.5, 2.25}}, {{17.5, 11.75}});
  ASSERT_EQ(points.size(), 3U) << "both ends and the diagonal";
  for (const ProfilePoint& point : points)
    EXPECT_NEAR(point.height, 2 * point.at[0] - 3 * point.at[1] + 100, 1e-12);
}

}  // namespace
}  // namespace lode::test
