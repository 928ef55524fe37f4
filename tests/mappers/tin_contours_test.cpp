#include "lode/mappers/tin_contours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "tests/locate/tin_fixtures.h"

namespace lode::test {
namespace {

ContourSet trace(const Tin& tin, const std::vector<double>& levels) {
  Progress progress;
  auto made = trace_contours(tin, levels, KeptLines::drawable, progress);
  if (!made) ADD_FAILURE() << made.error().message;
  return made ? std::move(made).value() : ContourSet{};
}

/// Among them some at just the heights of vertices.
std::vector<double> levels_of(const GridTin& one) {
  std::set<double> levels{-500, -100.5, -7, 0, 7, 20, 100, 250.25, 600};
  for (std::size_t v = 0; v < one.tin.heights.size(); v += 1 + one.tin.heights.size() / 12)
    levels.insert(one.tin.heights[v]);
  return {levels.begin(), levels.end()};
}

/// The number of triangles that a level crosses, a vertex at it being above.
std::size_t count_crossed(const Tin& tin, double level) {
  std::size_t n = 0;
  for (const auto& t : tin.triangles) {
    int above = 0;
    for (const std::uint32_t v : t) above += static_cast<int>(tin.heights[v] >= level);
    n += static_cast<std::size_t>(above == 1 || above == 2);
  }
  return n;
}

/// Where on edges a level crosses, by the definition: each with how many lines should end there.
using Crossings = std::multiset<std::pair<double, double>>;

Crossings crossings_of(const Tin& tin, double level, bool is_border) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> n_uses;
  for (const auto& t : tin.triangles)
    for (std::size_t i = 0; i < 3; ++i) ++n_uses[std::minmax(t[i], t[(i + 1) % 3])];
  Crossings crossings;
  for (const auto& [edge, n] : n_uses) {
    auto [u, v] = edge;
    if (is_border && n == 2) continue;
    if ((tin.heights[u] >= level) == (tin.heights[v] >= level)) continue;
    if (tin.heights[u] > tin.heights[v]) std::swap(u, v);
    const double share = (level - tin.heights[u]) / (tin.heights[v] - tin.heights[u]);
    const LatticePoint a = tin.vertices[u];
    const LatticePoint b = tin.vertices[v];
    crossings.insert({a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share});
  }
  return crossings;
}

TEST(tin_contours, have_the_points_where_levels_cross_edges_and_end_at_the_outline) {
  for (const GridTin& one : all_tins()) {
    const std::vector<double> levels = levels_of(one);
    const ContourSet made = trace(one.tin, levels);
    std::size_t n_points = 0;
    for (std::size_t level = 0; level < levels.size(); ++level) {
      const Crossings all = crossings_of(one.tin, levels[level], false);
      Crossings ends = crossings_of(one.tin, levels[level], true);
      for (const ContourLine& line : made.lines) {
        if (line.level != level) continue;
        n_points += line.points.size();
        ASSERT_GE(line.points.size(), 2U);
        EXPECT_EQ(line.is_ring, line.points.front() == line.points.back() && line.is_ring);
        for (std::size_t i = 0; i < line.points.size(); ++i) {
          const Point& p = line.points[i];
          EXPECT_TRUE(all.contains({p[0], p[1]})) << one.name;
          if (i > 0) EXPECT_NE(p, line.points[i - 1]);
        }
        if (line.is_ring) continue;
        for (const Point& p : {line.points.front(), line.points.back()}) {
          const auto end = ends.find({p[0], p[1]});
          ASSERT_NE(end, ends.end()) << one.name << ": a line ends where no outline is";
          ends.erase(end);
        }
      }
      // Every place of a crossing is on some line, but for lines of one point.
      std::set<std::pair<double, double>> met;
      for (const ContourLine& line : made.lines)
        if (line.level == level)
          for (const Point& p : line.points) met.insert({p[0], p[1]});
      for (const auto& p : all)
        if (!met.contains(p)) EXPECT_GT(made.n_left_out, 0U) << one.name;
    }
    EXPECT_EQ(made.n_points, n_points);
    EXPECT_TRUE(std::ranges::is_sorted(made.lines, {}, &ContourLine::level));
  }
}

TEST(tin_contours, cross_each_triangle_once_a_level) {
  // At half heights no vertex is at a level, and no point is left out.
  for (const GridTin& one : all_tins()) {
    if (one.name == "flat" || one.name == "two_by_two") continue;
    for (const double level : {-300.5, -0.5, 10.5, 333.5}) {
      const ContourSet made = trace(one.tin, {level});
      std::size_t n_segments = 0;
      for (const ContourLine& line : made.lines) n_segments += line.points.size() - 1;
      EXPECT_EQ(n_segments, count_crossed(one.tin, level)) << one.name;
      EXPECT_EQ(made.n_left_out, 0U);
      std::set<std::pair<double, double>> seen;
      for (const ContourLine& line : made.lines)
        for (std::size_t i = line.is_ring ? 1 : 0; i < line.points.size(); ++i)
          EXPECT_TRUE(seen.insert({line.points[i][0], line.points[i][1]}).second)
              << one.name << ": a line meets itself or another";
    }
  }
}

TEST(tin_contours, have_higher_ground_on_their_left) {
  for (const GridTin& one : all_tins()) {
    const ContourSet made = trace(one.tin, {-300.5, -0.5, 10.5, 333.5});
    for (const ContourLine& line : made.lines)
      for (std::size_t i = 1; i < line.points.size(); ++i) {
        const Point& p = line.points[i - 1];
        const Point& q = line.points[i];
        const Point way = q - p;
        const double size = std::hypot(way[0], way[1]);
        // A millionth of the way aside, still in the triangle unless that is a sliver.
        const double step = 1e-6 * std::min(1.0, size) / size;
        const Point middle = (p + q) * 0.5;
        const Point left{{middle[0] - step * way[1], middle[1] + step * way[0]}};
        const std::uint32_t t = find_by_trying(one.tin, middle);
        if (t == one.tin.triangles.size() || !holds_exactly(one.tin, t, left)) continue;
        EXPECT_GT(plane_at(one.tin, t, left), plane_at(one.tin, t, middle)) << one.name;
      }
  }
}

/// Twice the area to the left of a ring.
double ring_area(const ContourLine& line) {
  double area = 0;
  for (std::size_t i = 1; i < line.points.size(); ++i)
    area += line.points[i - 1][0] * line.points[i][1] - line.points[i - 1][1] * line.points[i][0];
  return area;
}

GridTin hand_made(const std::vector<std::vector<int>>& rows) {
  const auto height = [&](std::int32_t x, std::int32_t y) {
    return rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
  };
  return select_tin("hand_made",
                    make_grid<std::int16_t>(static_cast<std::int32_t>(rows[0].size()),
                                            static_cast<std::int32_t>(rows.size()), height),
                    0);
}

TEST(tin_contours, settle_summits_pits_plateaus_and_flats_by_one_rule) {
  const GridTin summit = hand_made({{0, 0, 0}, {0, 5, 0}, {0, 0, 0}});
  EXPECT_TRUE(trace(summit.tin, {5}).lines.empty()) << "one point";
  EXPECT_EQ(trace(summit.tin, {5}).n_left_out, 1U);
  ASSERT_EQ(trace(summit.tin, {3}).lines.size(), 1U);
  EXPECT_GT(ring_area(trace(summit.tin, {3}).lines[0]), 0) << "turns left round a summit";
  EXPECT_TRUE(trace(summit.tin, {0}).lines.empty()) << "nothing is below";
  const GridTin pit = hand_made({{9, 9, 9}, {9, 5, 9}, {9, 9, 9}});
  EXPECT_TRUE(trace(pit.tin, {5}).lines.empty());
  ASSERT_EQ(trace(pit.tin, {6}).lines.size(), 1U);
  EXPECT_LT(ring_area(trace(pit.tin, {6}).lines[0]), 0);
  const GridTin plateau = hand_made({{0, 0, 0, 0}, {0, 5, 5, 0}, {0, 5, 5, 0}, {0, 0, 0, 0}});
  const ContourSet border = trace(plateau.tin, {5});
  ASSERT_EQ(border.lines.size(), 1U) << "its outline, once";
  EXPECT_DOUBLE_EQ(ring_area(border.lines[0]), 2);
  const GridTin basin = hand_made({{9, 9, 9, 9}, {9, 5, 5, 9}, {9, 5, 5, 9}, {9, 9, 9, 9}});
  EXPECT_TRUE(trace(basin.tin, {5}).lines.empty()) << "all of it counts as above";
  const GridTin ridge = hand_made({{0, 0, 0, 0}, {0, 5, 5, 0}, {0, 0, 0, 0}});
  const ContourSet back_and_forth = trace(ridge.tin, {5});
  ASSERT_EQ(back_and_forth.lines.size(), 1U);
  EXPECT_EQ(back_and_forth.lines[0].points.size(), 3U);
  const GridTin flat = hand_made({{4, 4}, {4, 4}});
  EXPECT_TRUE(trace(flat.tin, {3, 4, 5}).lines.empty());
}

TEST(tin_contours, of_a_cone_are_circles_within_its_error) {
  const auto cone = [](std::int32_t x, std::int32_t y) { return 100 - std::hypot(x - 40, y - 40); };
  const double error = 0.25;
  const GridTin one = select_tin("cone", make_grid<float>(81, 81, cone), error);
  const ContourSet made = trace(one.tin, {70, 80, 90});
  ASSERT_EQ(made.lines.size(), 3U);
  for (const ContourLine& line : made.lines) {
    EXPECT_TRUE(line.is_ring);
    const double radius = 30 - 10 * line.level;
    // Slope 1: a vertical error is a horizontal one; between samples a cone bends by less than
    // 1 / (8 r) in a cell.
    for (const Point& p : line.points)
      EXPECT_NEAR(std::hypot(p[0] - 40, p[1] - 40), radius, 2 * error);
  }
}

TEST(tin_contours, stop_when_cancelled) {
  const GridTin one = select_tin("hills", make_grid<std::int16_t>(50, 40, hilly), 40);
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(trace_contours(one.tin, std::vector<double>{3}, KeptLines::drawable, cancelled));
}

}  // namespace
}  // namespace lode::test
