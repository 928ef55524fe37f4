#include "lode/delaunay/fixed_lines.h"

#include <cmath>
#include <numeric>

#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/lattice_side.h"
#include "lode/delaunay/point_insertion.h"
#include "lode/delaunay/tin_links.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/trials.h"

namespace lode::delaunay {
namespace {

using Edge = std::array<std::uint32_t, 2>;
using Line = std::array<LatticePoint, 2>;

int side(LatticePoint a, LatticePoint b, LatticePoint c) {
  const std::int64_t area = doubled_area(a, b, c);
  return (area > 0) - (area < 0);
}
bool is_between(LatticePoint a, LatticePoint b, LatticePoint p) {
  return side(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
         std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y);
}
/// Whether two segments have a point in common that is no end of both.
bool is_crossing(const Line& s, const Line& t) {
  if (side(s[0], s[1], t[0]) * side(s[0], s[1], t[1]) < 0 &&
      side(t[0], t[1], s[0]) * side(t[0], t[1], s[1]) < 0)
    return true;
  for (const LatticePoint p : t)
    if (is_between(s[0], s[1], p) && p != s[0] && p != s[1]) return true;
  for (const LatticePoint p : s)
    if (is_between(t[0], t[1], p) && p != t[0] && p != t[1]) return true;
  return s == t || (s[0] == t[1] && s[1] == t[0]);
}

/// Lines from node to node inside of a rectangle, that do not cross; many of them meet.
std::vector<Line> random_lines(oracles::Random& random, LatticePoint last, std::size_t n) {
  std::vector<Line> lines;
  const auto node = [&] {
    return LatticePoint{static_cast<std::int32_t>(random.below(last.x + 1)),
                        static_cast<std::int32_t>(random.below(last.y + 1))};
  };
  for (std::size_t tries = 0; tries < 20 * n && lines.size() < n; ++tries) {
    const bool is_joined = !lines.empty() && random.below(2) == 0;
    Line line{is_joined ? lines.back()[1] : node(), node()};
    if (random.below(3) == 0) line[1].y = line[0].y;  // Along a row, so that nodes lie on it.
    if (line[0] == line[1]) continue;
    if (std::ranges::none_of(lines, [&](const Line& other) { return is_crossing(line, other); }))
      lines.push_back(line);
  }
  return lines;
}

/// Twins are the edges that run the other way.
void expect_twins(const Tin& tin) {
  const auto found = find_twins(tin.triangles);
  EXPECT_EQ(tin.twins, found);
}

/// What constrained Delaunay means: all lines are made of edges, and no other edge has a
/// neighbour's corner in its triangle's circle.
void expect_constrained(const Tin& tin, const std::vector<Line>& lines) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> apexes;
  for (const auto& t : tin.triangles)
    for (std::size_t i = 0; i < 3; ++i) apexes[{t[i], t[(i + 1) % 3]}] = t[(i + 2) % 3];
  std::vector<std::int64_t> covered(lines.size());
  const auto length = [](LatticePoint a, LatticePoint b) {
    return std::gcd(std::int64_t{a.x} - b.x, std::int64_t{a.y} - b.y);
  };
  for (const auto& [edge, apex] : apexes) {
    const auto other = apexes.find({edge.second, edge.first});
    if (other == apexes.end()) continue;
    const LatticePoint a = tin.vertices[edge.first];
    const LatticePoint b = tin.vertices[edge.second];
    bool is_fixed = false;
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (is_between(lines[i][0], lines[i][1], a) && is_between(lines[i][0], lines[i][1], b)) {
        covered[i] += length(a, b);
        is_fixed = true;
      }
    EXPECT_TRUE(is_fixed ||
                test::circle_sign(a, b, tin.vertices[apex], tin.vertices[other->second]) <= 0);
  }
  // Both directions of each edge.
  for (std::size_t i = 0; i < lines.size(); ++i)
    EXPECT_EQ(covered[i], 2 * length(lines[i][0], lines[i][1])) << "line " << i;
}

TEST(fixed_lines, stay_edges_while_samples_are_inserted_round_and_on_them) {
  oracles::Random random(7);
  for (int trial = 0; trial < oracles::trials(200, 12); ++trial) {
    SCOPED_TRACE(trial);
    const std::int32_t n = 12 + static_cast<std::int32_t>(random.below(30));
    const HeightGrid grid = test::make_grid<float>(n, n + 3, [&](std::int32_t x, std::int32_t y) {
      return std::round(40 * std::sin(0.3 * x) * std::cos(0.2 * y) + random.uniform(0, 20));
    });
    // Not on the outline, which stays as it is whatever lines do.
    std::vector<Line> lines = random_lines(random, {n - 3, n}, 1 + random.below(12));
    for (Line& line : lines)
      for (LatticePoint& p : line) p = {p.x + 1, p.y + 1};
    const LatticePacking packing(n);
    std::vector<Edge> edges;
    for (const Line& line : lines) edges.push_back({packing.pack(line[0]), packing.pack(line[1])});
    const auto domain = find_domain(grid);
    ASSERT_TRUE(domain);
    Progress nobody;
    const auto fixed = fix_lines(packing, domain->triangles, edges, {}, nobody);
    ASSERT_TRUE(fixed) << fixed.error().message;
    EXPECT_TRUE(fixed->crossing.empty());
    for (const InsertionOrder order : {InsertionOrder::levels, InsertionOrder::strict})
      for (const double max_error : {0.0, 4.0, 15.0, 1000.0}) {
        LatticeMesh mesh(packing, fixed->triangles);
        mesh.cut(fixed->edges);
        Progress progress;
        const HeightRange range = height_range(grid);
        const auto& samples = std::get<HeightGrid::Samples<float>>(grid.heights);
        const auto report = insert_greedily(
            mesh, SampleRows<float>{samples.data(), grid.stride, packing}, range.lower, range.upper,
            {.max_error = max_error, .order = order}, progress);
        ASSERT_TRUE(report);
        EXPECT_TRUE(mesh.is_delaunay());
        const auto healed = mesh.heal();
        EXPECT_GE(healed.size(), fixed->edges.size());
        const Tin tin = to_tin(mesh, TinLinks::kept);
        EXPECT_LE(static_cast<double>(test::largest_error(tin, grid)), max_error);
        test::expect_fills(tin, grid);
        expect_twins(tin);
        expect_constrained(tin, lines);
      }
  }
}

TEST(fixed_lines, keep_a_limit_of_triangles_where_samples_lie_on_them) {
  const HeightGrid grid = test::make_grid<float>(
      17, 17, [](std::int32_t x, std::int32_t y) { return y == 8 ? 50 * std::sin(x) : 0; });
  const LatticePacking packing(17);
  const auto domain = find_domain(grid);
  Progress nobody;
  const auto fixed =
      fix_lines(packing, domain->triangles,
                std::vector<Edge>{{packing.pack({2, 8}), packing.pack({14, 8})}}, {}, nobody);
  ASSERT_TRUE(fixed) << fixed.error().message;
  for (std::uint64_t most = fixed->triangles.size(); most < 40; ++most) {
    LatticeMesh mesh(packing, fixed->triangles);
    mesh.cut(fixed->edges);
    Progress progress;
    const auto& samples = std::get<HeightGrid::Samples<float>>(grid.heights);
    const auto report = insert_greedily(
        mesh, SampleRows<float>{samples.data(), grid.stride, packing}, -50, 50,
        {.max_error = 0, .max_triangles = most, .order = InsertionOrder::strict}, progress);
    ASSERT_TRUE(report);
    EXPECT_LE(mesh.triangles().size(), most);
    EXPECT_GE(mesh.triangles().size() + 2, most);
  }
}

TEST(fixed_lines, that_cross_are_told) {
  const HeightGrid grid =
      test::make_grid<float>(9, 9, [](std::int32_t, std::int32_t) { return 0; });
  const LatticePacking packing(9);
  const auto domain = find_domain(grid);
  const std::vector<Edge> crossing{{packing.pack({1, 1}), packing.pack({6, 7})},
                                   {packing.pack({1, 7}), packing.pack({6, 2})}};
  Progress nobody;
  const auto fixed = fix_lines(packing, domain->triangles, crossing, {}, nobody);
  ASSERT_TRUE(fixed) << fixed.error().message;
  EXPECT_EQ(fixed->crossing, std::vector<std::uint32_t>{1});
  EXPECT_EQ(fixed->edges, (std::vector<Edge>{crossing[0]}));
}

/// All points, with lines between some of them.
TEST(fixed_lines, of_scattered_points_stay_edges) {
  oracles::Random random(11);
  for (int trial = 0; trial < oracles::trials(200, 10); ++trial) {
    SCOPED_TRACE(trial);
    constexpr std::int32_t kLast = 60;
    std::set<std::pair<std::int32_t, std::int32_t>> places{
        {0, 0}, {kLast, 0}, {kLast, kLast}, {0, kLast}};
    for (int i = 0; i < 150; ++i)
      places.insert({static_cast<std::int32_t>(1 + random.below(kLast - 1)),
                     static_cast<std::int32_t>(1 + random.below(kLast - 1))});
    std::vector<Line> lines = random_lines(random, {kLast - 2, kLast - 2}, 8);
    for (Line& line : lines)
      for (LatticePoint& p : line) {
        p = {p.x + 1, p.y + 1};
        places.insert({p.x, p.y});
      }
    std::vector<LatticePoint> nodes;
    std::vector<double> heights;
    for (const auto& [x, y] : places) {
      nodes.push_back({x, y});
      heights.push_back(static_cast<double>(random.below(50)));
    }
    const auto number = [&](LatticePoint p) {
      return static_cast<std::uint32_t>(std::ranges::find(nodes, p) - nodes.begin());
    };
    std::vector<Edge> edges;
    for (const Line& line : lines) edges.push_back({number(line[0]), number(line[1])});
    const ListedNodes listed(nodes);
    const std::vector<std::array<std::uint32_t, 3>> square{
        {number({0, 0}), number({kLast, 0}), number({kLast, kLast})},
        {number({0, 0}), number({kLast, kLast}), number({0, kLast})}};
    Progress nobody;
    const auto fixed = fix_lines(listed, square, edges, {}, nobody);
    ASSERT_TRUE(fixed) << fixed.error().message;
    std::vector<std::uint32_t> triangle_of;
    for (const LatticePoint p : nodes) {
      const auto holds = std::ranges::find_if(fixed->triangles, [&](const auto& t) {
        return side(nodes[t[0]], nodes[t[1]], p) >= 0 && side(nodes[t[1]], nodes[t[2]], p) >= 0 &&
               side(nodes[t[2]], nodes[t[0]], p) >= 0;
      });
      triangle_of.push_back(static_cast<std::uint32_t>(holds - fixed->triangles.begin()));
    }
    for (const double max_error : {0.0, 20.0}) {
      PointMesh mesh(listed, fixed->triangles);
      mesh.cut(fixed->edges);
      Progress progress;
      const auto report = insert_points(mesh, {nodes, heights, triangle_of}, {0, 50},
                                        {.max_error = max_error}, progress);
      ASSERT_TRUE(report);
      EXPECT_TRUE(mesh.is_delaunay());
      mesh.heal();
      const Tin tin = to_tin(mesh, TinLinks::kept);
      expect_twins(tin);
      expect_constrained(tin, lines);
      if (max_error == 0) EXPECT_EQ(tin.vertices.size(), nodes.size());
    }
  }
}

}  // namespace
}  // namespace lode::delaunay
