#include "lode/delaunay/point_insertion.h"

#include <cmath>
#include <string>

#include "tests/delaunay/point_fixtures.h"

namespace lode::delaunay {
namespace {

using test::Points;

struct Answer {
  Tin tin;
  GreedyReport report;
};

Answer insert(const Points& points, const GreedyOptions& options) {
  const test::Start start = test::start_of(points);
  PointMesh mesh(ListedNodes(points.nodes), start.triangles);
  Progress progress;
  const auto report = insert_points(mesh, {points.nodes, points.heights, start.triangle_of},
                                    points.range(), options, progress);
  EXPECT_TRUE(report);
  return {to_tin(mesh), *report};
}

Tin insert_all(const Points& points) {
  const test::Start start = test::start_of(points);
  PointMesh mesh(ListedNodes(points.nodes), start.triangles);
  Progress progress;
  EXPECT_TRUE(insert_all_points(mesh, {points.nodes, points.heights, start.triangle_of}, progress));
  return to_tin(mesh);
}

double hills(double x, double y) { return 90 * std::sin(0.1 * x) * std::cos(0.07 * y) + x / 10; }

struct Case {
  std::string name;
  std::vector<LatticePoint> nodes;
};

std::vector<LatticePoint> grid_nodes(std::int32_t n) {
  std::vector<LatticePoint> nodes;
  for (std::int32_t y = 0; y < n; ++y)
    for (std::int32_t x = 0; x < n; ++x) nodes.push_back({x, y});
  return nodes;
}

/// Dense spots far apart, as tracks of ships are, up to the largest coordinates.
std::vector<LatticePoint> far_nodes() {
  constexpr std::int32_t kLast = (1 << 30) - 1;
  std::vector<LatticePoint> nodes{{0, 0}, {kLast, 0}, {kLast, kLast}, {0, kLast}};
  for (const LatticePoint& p : test::random_nodes(60, 40, 7)) {
    nodes.push_back({kLast - p.x, p.y});
    nodes.push_back({p.x + 500'000'000, p.y + 300'000'000});
  }
  for (const LatticePoint& p : test::random_nodes(60, kLast, 8)) nodes.push_back(p);
  return nodes;
}

/// Most points lie inside of the hull's edges, which are oblique.
std::vector<LatticePoint> edge_nodes() {
  std::vector<LatticePoint> nodes;
  for (std::int32_t i = 0; i <= 30; ++i) {
    nodes.push_back({2 * i, i});
    nodes.push_back({90 - 3 * i, 90 + 2 * i});
    nodes.push_back({i, 3 * i});
  }
  return nodes;
}

std::vector<Case> cases() {
  return {{"three", {{0, 0}, {5, 1}, {2, 9}}},
          {"a point on an edge", {{0, 0}, {8, 4}, {4, 2}, {0, 9}}},
          {"random", test::random_nodes(200, 1000, 1)},
          {"crowded", test::random_nodes(300, 20, 2)},
          {"grid", grid_nodes(14)},
          {"far", far_nodes()},
          {"edges", edge_nodes()}};
}

TEST(point_insertion, keeps_the_error_at_every_point_and_delaunay_in_both_orders) {
  for (const Case& one : cases()) {
    const Points points = test::make_points(one.nodes, hills);
    for (const InsertionOrder order : {InsertionOrder::levels, InsertionOrder::strict})
      for (const double max_error : {0.0, 1.0, 30.0, 1e12}) {
        SCOPED_TRACE(testing::Message() << one.name << ", " << max_error);
        const Answer answer = insert(points, {.max_error = max_error, .order = order});
        EXPECT_LE(test::largest_error(answer.tin, points), answer.report.achieved_error);
        EXPECT_LE(answer.report.achieved_error, max_error);
        EXPECT_TRUE(answer.report.is_within_error);
        test::expect_fills_hull(answer.tin, points);
        test::expect_empty_circles(answer.tin);
      }
  }
}

TEST(point_insertion, inserts_all_points_where_that_is_asked) {
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.name);
    const Points points = test::make_points(one.nodes, [](double, double) { return 1.0; });
    const Tin tin = insert_all(points);
    EXPECT_EQ(tin.vertices, points.nodes);
    test::expect_fills_hull(tin, points);
    test::expect_empty_circles(tin);
  }
}

TEST(point_insertion, leaves_level_ground_alone_and_finds_what_rises_from_it) {
  const Points flat = test::make_points(grid_nodes(20), [](double, double) { return 0.1; });
  const Answer level = insert(flat, {.max_error = 0});
  EXPECT_EQ(level.tin.triangles.size(), 2U) << "rounding was taken for an error";
  EXPECT_EQ(level.report.achieved_error, 0);
  const Points spike = test::make_points(
      grid_nodes(20), [](double x, double y) { return x == 7 && y == 11 ? 0.6 : 0.1; });
  EXPECT_EQ(insert(spike, {.max_error = 0.46}).tin.vertices.size(), 5U);
}

TEST(point_insertion, tells_centimetres_apart_at_a_billion) {
  const auto relief = [](double x, double y) {
    return 1e9 + std::round(5 * std::sin(x / 9) * std::cos(y / 7)) / 100;
  };
  const Points points = test::make_points(test::random_nodes(400, 300, 3), relief);
  for (const double max_error : {0.02, 0.005}) {
    const Answer answer = insert(points, {.max_error = max_error});
    EXPECT_LE(test::largest_error(answer.tin, points), answer.report.achieved_error);
    EXPECT_LE(answer.report.achieved_error, max_error);
    EXPECT_LT(answer.tin.vertices.size(), points.nodes.size());
  }
}

TEST(point_insertion, stops_at_a_number_of_triangles_with_the_worst_points_inserted) {
  const Points points = test::make_points(test::random_nodes(300, 500, 4), hills);
  double before = INFINITY;
  for (const std::uint64_t n : {20, 60, 120}) {
    const Answer answer = insert(points, {.max_triangles = n, .order = InsertionOrder::strict});
    EXPECT_LE(answer.tin.triangles.size(), n);
    EXPECT_GE(answer.tin.triangles.size() + 1, n) << "one more would have fitted";
    EXPECT_FALSE(answer.report.is_within_error);
    EXPECT_LE(test::largest_error(answer.tin, points), answer.report.achieved_error);
    EXPECT_LT(answer.report.achieved_error, before);
    before = answer.report.achieved_error;
  }
}

/// Every insertion would move all points to another list were they taken in rows.
TEST(point_insertion, takes_large_planes_in_no_time) {
  const Points points =
      test::make_points(grid_nodes(300), [](double x, double y) { return x / 3 + y / 7; });
  const Answer answer = insert(points, {.max_error = 0});
  EXPECT_LE(answer.report.achieved_error, 0);
  EXPECT_EQ(insert_all(points).vertices, points.nodes);
}

TEST(convex_hull, has_just_the_corners_that_turn_left) {
  using Numbers = std::vector<std::uint32_t>;
  EXPECT_EQ(convex_hull({}), Numbers());
  EXPECT_EQ(convex_hull(std::vector<LatticePoint>{{3, 4}}), Numbers{0});
  EXPECT_EQ(convex_hull(std::vector<LatticePoint>{{3, 4}, {3, 5}}), (Numbers{0, 1}));
  EXPECT_EQ(convex_hull(std::vector<LatticePoint>{{0, 0}, {2, 1}, {4, 2}, {6, 3}}),
            (Numbers{0, 3}));
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.name);
    const Points points = test::make_points(one.nodes, hills);
    const Numbers hull = convex_hull(points.nodes);
    test::Int128 area = 0;
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const LatticePoint a = points.nodes[hull[i]];
      const LatticePoint b = points.nodes[hull[(i + 1) % hull.size()]];
      const LatticePoint c = points.nodes[hull[(i + 2) % hull.size()]];
      EXPECT_GT(doubled_area(a, b, c), 0);
      area += test::Int128{a.x} * b.y - test::Int128{a.y} * b.x;
    }
    EXPECT_TRUE(area == test::doubled_hull_area(points.nodes));
  }
}

}  // namespace
}  // namespace lode::delaunay
