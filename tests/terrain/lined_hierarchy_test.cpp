// Features as edges of triangles that are refined into triangulations.
#include "lode/api/lined_hierarchy.h"

#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "lode/api/terrain_lines.h"
#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"
#include "lode/models/terrain/triangle_hierarchy/variable.h"
#include "lode/refine/focus.h"
#include "tests/terrain/hierarchy_fixtures.h"

namespace lode {
namespace {

using delaunay::Tin;
using hierarchical_delaunay::HierarchicalDelaunay;
using triangle_hierarchy::FineGrid;
using triangle_hierarchy::FirstMesh;
using triangle_hierarchy::Hierarchy;

struct Lined {
  FineGrid grid;
  PointTerrain terrain;
  FirstMesh first;
};

Lined lined(const HeightGrid& heights, double relief, double tolerance) {
  Progress progress;
  auto made = add_lines(heights, {.least_relief = relief}, progress);
  auto grid = FineGrid::make(heights);
  EXPECT_TRUE(made && grid);
  auto first = first_mesh(made->terrain, *grid, tolerance, progress);
  EXPECT_TRUE(first);
  return {*std::move(grid), std::move(made->terrain), *std::move(first)};
}

/// Vertices by place, and edges.
class EdgesOf {
 public:
  explicit EdgesOf(const Tin& tin) {
    for (std::uint32_t v = 0; v < tin.vertices.size(); ++v)
      vertices_[{tin.vertices[v].x, tin.vertices[v].y}] = v;
    for (const auto& t : tin.triangles)
      for (std::size_t i = 0; i < 3; ++i)
        for (const std::size_t j : {(i + 1) % 3, (i + 2) % 3}) edges_.insert({t[i], t[j]});
  }

  /// Goes along a line from sample to sample: each that is a vertex must be joined to the next.
  void expect_line(std::int32_t scale, LatticePoint from, LatticePoint to) const {
    const auto sign = [](std::int32_t d) { return d > 0 ? 1 : d < 0 ? -1 : 0; };
    const LatticePoint step{sign(to.x - from.x) * scale, sign(to.y - from.y) * scale};
    ASSERT_TRUE(vertices_.contains({from.x, from.y}));
    ASSERT_TRUE(vertices_.contains({to.x, to.y}));
    std::uint32_t last = vertices_.at({from.x, from.y});
    for (LatticePoint p = from; p != to;) {
      p = {p.x + step.x, p.y + step.y};
      ASSERT_TRUE(p.x >= 0 && p.y >= 0 && p.x < 1 << 20 && p.y < 1 << 20);
      const auto found = vertices_.find({p.x, p.y});
      if (found == vertices_.end()) continue;
      EXPECT_TRUE(edges_.contains({last, found->second})) << p.x << ", " << p.y;
      last = found->second;
    }
  }

 private:
  std::map<std::pair<int, int>, std::uint32_t> vertices_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges_;
};

/// Rows, columns and diagonals, so that crossings are samples.
void expect_straight(const Hierarchy& h) {
  for (const auto& [a, b] : h.lines) {
    const LatticePoint from = h.vertices[a];
    const LatticePoint to = h.vertices[b];
    const std::int32_t dx = std::abs(to.x - from.x);
    const std::int32_t dy = std::abs(to.y - from.y);
    EXPECT_TRUE(dx == 0 || dy == 0 || dx == dy);
  }
}

void expect_lines(const Hierarchy& h, const Tin& tin) {
  const EdgesOf edges(tin);
  for (const auto& [a, b] : h.lines) edges.expect_line(h.scale(), h.vertices[a], h.vertices[b]);
}

void expect_lined_levels(const Hierarchy& h, const HeightGrid& heights, const Lined& from) {
  ASSERT_EQ(h.lines.size(), from.terrain.domain.lines.size());
  expect_straight(h);
  test::expect_hierarchy(h);
  for (int level = 0; level < h.n_levels(); ++level) {
    SCOPED_TRACE(testing::Message() << "level " << level);
    const Tin tin = tin_of_level(h, level, delaunay::TinLinks::left_out);
    test::expect_within(tin, h.scale(), heights, h.tolerances[static_cast<std::size_t>(level)]);
    expect_lines(h, tin);
  }
  Progress progress;
  VerifyReport report;
  ASSERT_TRUE(check_lines(h, progress, report));
  ASSERT_TRUE(compare_lines(h, from.terrain, report));
  EXPECT_TRUE(report.passed());
}

constexpr std::array kReliefs{0.0, 40.0};
const std::vector<double> kTolerances{300, 40, 7, 0.5, 0};

/// `build`: a hierarchy of what lined() gives.
template <typename Build>
void expect_lines_at_every_level(const Build& build) {
  for (const test::TerrainCase& c : test::terrain_cases())
    for (const double relief : kReliefs) {
      SCOPED_TRACE(testing::Message() << c.name << ", relief " << relief);
      const Lined from = lined(c.grid, relief, kTolerances.front());
      const auto made = build(from);
      ASSERT_TRUE(made);
      expect_lined_levels(made->hierarchy, c.grid, from);
    }
}

TEST(lined_hierarchy, has_features_as_edges_of_every_adaptive_level) {
  Progress progress;
  expect_lines_at_every_level([&](const Lined& from) {
    return adaptive_triangulation::build(from.grid, kTolerances, {2}, progress, &from.first);
  });
}

TEST(lined_hierarchy, has_features_as_edges_of_every_delaunay_level) {
  Progress progress;
  expect_lines_at_every_level([&](const Lined& from) {
    return hierarchical_delaunay::build(from.grid, kTolerances, {2}, progress, &from.first);
  });
}

TEST(lined_hierarchy, has_features_as_edges_where_tolerances_vary) {
  for (const test::TerrainCase& c : test::terrain_cases()) {
    SCOPED_TRACE(c.name);
    const Lined from = lined(c.grid, 0, kTolerances.front());
    Progress progress;
    const auto made =
        hierarchical_delaunay::build(from.grid, kTolerances, {2}, progress, &from.first);
    ASSERT_TRUE(made);
    const auto chains = triangle_hierarchy::EdgeChains::find_in(made->hierarchy);
    ASSERT_TRUE(chains);
    const double x = c.grid.n_columns / 3.0;
    const double y = c.grid.n_rows / 3.0;
    for (const double outside : {45.0, 1000.0}) {
      FocusDemand focus;
      focus.foci = {BoxFocus{{{{x, y, -1e9}}, {{x + 9, y + 7, 1e9}}}}};
      focus.inside = 0.5;
      focus.outside = outside;
      for (const bool with_raster : {false, true}) {
        const Hierarchy& h = made->hierarchy;
        const Tin tin =
            with_raster
                ? tin_of_demand(h, *chains, triangle_hierarchy::MeasuredPatches(from.grid), focus)
                : tin_of_demand(h, *chains, triangle_hierarchy::BoundedPatches(h), focus);
        expect_lines(h, tin);
      }
    }
  }
}

TEST(lined_hierarchy, is_told_from_one_whose_lines_are_no_edges) {
  const auto heights = test::make_grid<float>(33, 29, test::hills_with_spikes);
  const Lined from = lined(heights, 40, 300);
  Progress progress;
  auto made = hierarchical_delaunay::build(from.grid, kTolerances, {1}, progress, &from.first);
  ASSERT_TRUE(made);
  Hierarchy& h = made->hierarchy;
  ASSERT_GE(h.lines.size(), 3U);
  // To the vertex that is farthest away, to which no line goes.
  const LatticePoint from_place = h.vertices[h.lines[1][0]];
  const auto distance = [&](std::uint32_t v) {
    return std::hypot(h.vertices[v].x - from_place.x, h.vertices[v].y - from_place.y);
  };
  for (std::uint32_t v = 0; v < h.vertices_until[0]; ++v)
    if (distance(v) > distance(h.lines[1][1])) h.lines[1][1] = v;
  VerifyReport report;
  ASSERT_TRUE(check_lines(h, progress, report));
  ASSERT_TRUE(compare_lines(h, from.terrain, report));
  ASSERT_EQ(report.checks.size(), 2U);
  EXPECT_FALSE(report.checks[0].passed);
  EXPECT_FALSE(report.checks[1].passed);
  // Breaklines lie on a finer lattice.
  auto others = add_lines(heights, {.breaklines = {{{{3, 4, 5}}, {{20, 21, 9}}}}}, progress);
  ASSERT_TRUE(others);
  EXPECT_FALSE(compare_lines(h, others->terrain, report));
}

}  // namespace
}  // namespace lode
