#include "lode/mappers/tin_bands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "tests/locate/tin_fixtures.h"

namespace lode::test {
namespace {

std::vector<BandPolygon> bands_of(const Tin& tin, const std::vector<double>& levels) {
  Progress progress;
  auto made = find_bands(tin, levels, progress);
  if (!made) ADD_FAILURE() << made.error().message;
  return made ? std::move(made).value() : std::vector<BandPolygon>{};
}

/// Twice the area of what a half-space of heights leaves of a polygon with heights.
using HighPoint = std::array<double, 3>;
std::vector<HighPoint> cut_above(const std::vector<HighPoint>& polygon, double level, double sign) {
  std::vector<HighPoint> left;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const HighPoint& a = polygon[i];
    const HighPoint& b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[2] - level);
    const double db = sign * (b[2] - level);
    if (da >= 0) left.push_back(a);
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      const double s = da / (da - db);
      left.push_back({a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), level});
    }
  }
  return left;
}

/// Of each band, by cutting every triangle.
std::vector<double> areas_by_cutting(const Tin& tin, const std::vector<double>& levels) {
  std::vector<double> areas(levels.size() + 1, 0);
  for (const auto& t : tin.triangles)
    for (std::size_t band = 0; band <= levels.size(); ++band) {
      std::vector<HighPoint> part;
      for (const std::uint32_t v : t)
        part.push_back({static_cast<double>(tin.vertices[v].x),
                        static_cast<double>(tin.vertices[v].y), tin.heights[v]});
      // A flat triangle at a level is above it.
      const bool is_flat = part[0][2] == part[1][2] && part[0][2] == part[2][2];
      if (is_flat && band < levels.size() && part[0][2] == levels[band]) continue;
      if (band > 0) part = cut_above(part, levels[band - 1], 1);
      if (band < levels.size()) part = cut_above(part, levels[band], -1);
      for (std::size_t i = 1; i + 1 < part.size(); ++i)
        areas[band] += (part[i][0] - part[0][0]) * (part[i + 1][1] - part[0][1]) -
                       (part[i][1] - part[0][1]) * (part[i + 1][0] - part[0][0]);
    }
  return areas;
}

std::vector<std::vector<double>> level_lists(const GridTin& one) {
  std::vector<std::vector<double>> lists{
      {-500.5, -100.25, 0.5, 33.25, 250.5}, {7}, {0}, {1e6}, {-1e6, 1e6}};
  std::set<double> ties;
  for (std::size_t v = 0; v < one.tin.heights.size(); v += 1 + one.tin.heights.size() / 9)
    ties.insert(one.tin.heights[v]);
  lists.emplace_back(ties.begin(), ties.end());
  lists.push_back({-400, -300, -200, -100, 0, 100, 200, 300, 400});
  return lists;
}

TEST(tin_bands, have_the_areas_of_what_is_cut_out_of_triangles) {
  for (const GridTin& one : all_tins())
    for (const std::vector<double>& levels : level_lists(one)) {
      std::vector<double> areas(levels.size() + 1, 0);
      for (const BandPolygon& polygon : bands_of(one.tin, levels))
        for (const Ring& ring : polygon.rings) areas[polygon.band] += doubled_area(ring);
      const std::vector<double> expected = areas_by_cutting(one.tin, levels);
      // Some thousand roundings of areas below 1e4.
      for (std::size_t band = 0; band < areas.size(); ++band)
        EXPECT_NEAR(areas[band], expected[band], 1e-7) << one.name << " band " << band;
    }
}

TEST(tin_bands, have_simple_rings_and_holes_inside) {
  for (const GridTin& one : all_tins())
    for (const std::vector<double>& levels : level_lists(one))
      for (const BandPolygon& polygon : bands_of(one.tin, levels)) {
        ASSERT_FALSE(polygon.rings.empty());
        double area = 0;
        std::set<std::pair<Point, Point>> segments;
        for (const Ring& ring : polygon.rings)
          for (std::size_t i = 1; i < ring.size(); ++i) {
            EXPECT_TRUE(segments.insert({ring[i - 1], ring[i]}).second);
            EXPECT_FALSE(segments.contains({ring[i], ring[i - 1]})) << one.name << ": no inside";
          }
        for (std::size_t r = 0; r < polygon.rings.size(); ++r) {
          const Ring& ring = polygon.rings[r];
          EXPECT_GE(ring.size(), 4U);
          EXPECT_EQ(ring.front(), ring.back());
          const std::set<Point> points(ring.begin(), ring.end());
          EXPECT_EQ(points.size(), ring.size() - 1) << one.name << ": a point comes twice";
          EXPECT_EQ(doubled_area(ring) > 0, r == 0);
          area += doubled_area(ring);
        }
        EXPECT_GT(area, 0);
      }
}

TEST(tin_bands, are_the_same_segments_as_contours_and_outlines) {
  // Every segment of a polygon has the band on its left; inside of the domain another polygon of
  // the next band has it the other way round.
  for (const GridTin& one : all_tins()) {
    const std::vector<double> levels{-300.5, -0.5, 10.5, 333.5};
    std::map<std::pair<Point, Point>, std::uint32_t> band_at;
    const std::vector<BandPolygon> polygons = bands_of(one.tin, levels);
    for (const BandPolygon& polygon : polygons)
      for (const Ring& ring : polygon.rings)
        for (std::size_t i = 1; i < ring.size(); ++i)
          EXPECT_TRUE(band_at.insert({{ring[i - 1], ring[i]}, polygon.band}).second) << one.name;
    for (const auto& [segment, band] : band_at) {
      const auto other = band_at.find({segment.second, segment.first});
      if (other != band_at.end()) {
        EXPECT_EQ(std::max(other->second, band) - std::min(other->second, band), 1U);
        continue;
      }
      // On the outline, which runs along columns and rows.
      EXPECT_TRUE(segment.first[0] == segment.second[0] || segment.first[1] == segment.second[1])
          << one.name;
    }
  }
}

TEST(tin_bands, stop_when_cancelled) {
  const GridTin one = select_tin("hills", make_grid<std::int16_t>(50, 40, hilly), 40);
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(find_bands(one.tin, std::vector<double>{3}, cancelled));
}

TEST(simple_rings, are_cut_where_points_come_back) {
  // Two squares that share a corner, as one ring; and a spike.
  const Ring eight{{{0, 0}}, {{2, 0}}, {{2, 2}}, {{4, 2}}, {{4, 4}},
                   {{2, 4}}, {{2, 2}}, {{0, 2}}, {{0, 0}}};
  const std::vector<Ring> squares = cut_at_repeated_points(eight);
  ASSERT_EQ(squares.size(), 2U);
  EXPECT_EQ(doubled_area(squares[0]), 8);
  EXPECT_EQ(doubled_area(squares[1]), 8);
  const Ring spike{{{0, 0}}, {{2, 0}}, {{5, 0}}, {{2, 0}}, {{1, 2}}, {{0, 0}}};
  ASSERT_EQ(cut_at_repeated_points(spike).size(), 1U);
  EXPECT_EQ(doubled_area(cut_at_repeated_points(spike)[0]), 4);
  EXPECT_TRUE(cut_at_repeated_points({{{1, 1}}, {{2, 2}}, {{1, 1}}}).empty());
}

TEST(simple_rings, follow_the_inside_where_rings_meet) {
  // A square with a hole that shares an edge with it: the hole opens outwards.
  const Ring outer{{{0, 0}}, {{2, 0}}, {{4, 0}}, {{6, 0}}, {{6, 6}}, {{0, 6}}, {{0, 0}}};
  const Ring open{{{2, 0}}, {{2, 2}}, {{4, 2}}, {{4, 0}}, {{2, 0}}};
  const auto opened = follow_inside({outer, open});
  ASSERT_EQ(opened.size(), 1U);
  EXPECT_EQ(doubled_area(opened[0]), 72 - 8);
  // A hole that touches it in two points cuts it in two.
  const Ring square{{{0, 0}}, {{6, 0}}, {{6, 3}}, {{6, 6}}, {{0, 6}}, {{0, 3}}, {{0, 0}}};
  const Ring bar{{{0, 3}}, {{3, 4}}, {{6, 3}}, {{3, 2}}, {{0, 3}}};
  const auto halves = follow_inside({square, bar});
  ASSERT_EQ(halves.size(), 2U);
  EXPECT_EQ(doubled_area(halves[0]) + doubled_area(halves[1]), 72 - 12);
  // One that touches it in a point stays with it, and is cut off as a hole.
  const Ring drop{{{0, 3}}, {{2, 4}}, {{4, 3}}, {{2, 2}}, {{0, 3}}};
  const auto whole = follow_inside({square, drop});
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_EQ(cut_at_repeated_points(whole[0]).size(), 2U);
}

TEST(simple_rings, hold_the_holes_that_they_are_the_smallest_round) {
  const auto square = [](double at, double size, bool is_hole) {
    Ring ring{
        {{at, at}}, {{at + size, at}}, {{at + size, at + size}}, {{at, at + size}}, {{at, at}}};
    if (is_hole) std::ranges::reverse(ring);
    return ring;
  };
  const auto polygons = nest_rings(
      {square(0, 100, false), square(1, 10, false), square(2, 5, true), square(20, 5, true)});
  ASSERT_EQ(polygons.size(), 2U);
  EXPECT_EQ(polygons[0].size(), 2U);
  EXPECT_EQ(polygons[0][1][0], (Point{{20, 20}}));
  ASSERT_EQ(polygons[1].size(), 2U);
}

}  // namespace
}  // namespace lode::test
