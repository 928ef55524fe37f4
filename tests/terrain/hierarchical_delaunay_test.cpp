// Chains, Delaunay refinements, and variable resolution.
#include <algorithm>
#include <array>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/models/terrain/hierarchical_delaunay/polygon.h"
#include "lode/models/terrain/hierarchical_delaunay/variable.h"
#include "lode/refine/focus.h"
#include "tests/terrain/hierarchy_fixtures.h"

namespace lode::test {
namespace {

using delaunay::Tin;
using hierarchical_delaunay::HierarchicalDelaunay;
using triangle_hierarchy::FineGrid;
using triangle_hierarchy::Place;

struct Built {
  FineGrid grid;
  HierarchicalDelaunay model;
};

Built build(const HeightGrid& heights, std::span<const double> levels = kLevels) {
  Progress progress;
  auto grid = FineGrid::make(heights);
  EXPECT_TRUE(grid);
  auto model = hierarchical_delaunay::build(*grid, levels, {2}, progress);
  EXPECT_TRUE(model);
  return {*std::move(grid), *std::move(model)};
}

TEST(hierarchical_delaunay, begins_with_a_delaunay_triangulation) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const std::array levels{20.0};
    const Built built = build(c.grid, levels);
    const Tin tin = tin_of_level(built.model.hierarchy, 0, delaunay::TinLinks::left_out);
    if (c.grid.n_missing() == 0)
      delaunay::test::expect_empty_circles(tin);
    else
      delaunay::test::expect_locally_delaunay(tin);
  }
}

TEST(hierarchical_delaunay, refines_each_triangle_by_a_delaunay_triangulation) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const Built built = build(c.grid);
    const Hierarchy& h = built.model.hierarchy;
    for (std::uint32_t r = 0; r < h.refinements.size(); ++r) {
      const auto [first, end] = h.triangles_of(r);
      Tin tin;
      tin.vertices = h.vertices;
      for (std::uint32_t t = first; t < end; ++t) tin.triangles.push_back(h.triangles[t].corner);
      delaunay::test::expect_locally_delaunay(tin);
    }
  }
}

std::size_t level_of_triangle(const Hierarchy& h, std::uint32_t triangle) {
  std::size_t level = 0;
  while (triangle >= h.triangles_until[level]) ++level;
  return level;
}

TEST(hierarchical_delaunay, puts_all_of_a_chain_into_both_triangles_and_nothing_more) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const Built built = build(c.grid);
    const Hierarchy& h = built.model.hierarchy;
    for (const auto& refinement : h.refinements) {
      const auto [first, end] = h.triangles_of(h.triangles[refinement.triangle].refinement);
      std::map<std::uint32_t, std::uint32_t> border;
      std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
      for (std::uint32_t t = first; t < end; ++t)
        for (std::size_t i = 0; i < 3; ++i)
          edges.insert({h.triangles[t].corner[i], h.triangles[t].corner[(i + 1) % 3]});
      for (const auto& [a, b] : edges)
        if (!edges.contains({b, a})) border[a] = b;
      const auto& corner = h.triangles[refinement.triangle].corner;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t to = corner[(i + 1) % 3];
        std::vector<std::uint32_t> between;
        for (std::uint32_t v = border[corner[i]]; v != to; v = border[v]) {
          ASSERT_LT(between.size(), border.size());
          between.push_back(v);
        }
        const auto found = built.model.chains.find(corner[i], to);
        std::vector<std::uint32_t> chain(found.begin(), found.end());
        if (corner[i] > to) std::ranges::reverse(chain);
        // The edge may have stayed whole here, and been refined at a later level.
        if (between.empty() && !chain.empty())
          EXPECT_GE(chain.front(), h.vertices_until[level_of_triangle(h, first)]);
        else
          EXPECT_EQ(between, chain);
      }
    }
  }
}

Box3d world_box(double x_low, double y_low, double x_high, double y_high) {
  return {{{x_low, y_low, -1e9}}, {{x_high, y_high, 1e9}}};
}

TEST(hierarchical_delaunay, varies_within_every_demand) {
  for (const TerrainCase& c : terrain_cases()) {
    const Built built = build(c.grid);
    const Hierarchy& h = built.model.hierarchy;
    oracles::Random random(3);
    for (int n = 0; n < 8; ++n) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << n);
      const double x = random.uniform(0, c.grid.n_columns);
      const double y = random.uniform(0, c.grid.n_rows);
      FocusDemand focus;
      focus.foci = {BoxFocus{world_box(x, y, x + 7, y + 5)}};
      // Errors are kept rounded up, so the last tolerance is a little larger.
      focus.inside = n % 2 == 0 ? 7.5 : 0.01;
      focus.outside = n % 4 < 2 ? 200 : 45;
      const auto tin = tin_of_demand(built.model.hierarchy, built.model.chains, built.grid, focus);
      ASSERT_TRUE(tin);
      delaunay::test::expect_fills(*tin, c.grid, h.scale());
      expect_within(*tin, h.scale(), c.grid, focus.outside);
      for (std::size_t t = 0; t < tin->triangles.size(); ++t) {
        const auto at = [&](std::size_t i) { return tin->vertices[tin->triangles[t][i]]; };
        const double scale = h.scale();
        if (std::max({at(0).x, at(1).x, at(2).x}) / scale < x ||
            std::min({at(0).x, at(1).x, at(2).x}) / scale > x + 7 ||
            std::max({at(0).y, at(1).y, at(2).y}) / scale < y ||
            std::min({at(0).y, at(1).y, at(2).y}) / scale > y + 5)
          continue;
        EXPECT_LE(static_cast<double>(tin->errors[t]), focus.inside);
      }
      const auto finest = tin_of_level(h, h.n_levels() - 1, delaunay::TinLinks::left_out);
      EXPECT_LE(tin->triangles.size(), finest.triangles.size());
    }
  }
}

using Places = std::array<std::array<std::int32_t, 2>, 3>;

Places places_of(const std::array<std::uint32_t, 3>& corner,
                 const std::vector<LatticePoint>& vertices) {
  Places places{};
  for (std::size_t i = 0; i < 3; ++i) places[i] = {vertices[corner[i]].x, vertices[corner[i]].y};
  std::ranges::sort(places);
  return places;
}

/// A sliver between vertices of a chain has no samples in it, and would be a wall.
TEST(hierarchical_delaunay, states_errors_of_edges_between_levels) {
  int n_edges = 0;
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const Built built = build(c.grid);
    const Hierarchy& h = built.model.hierarchy;
    std::set<Places> own;
    std::set<std::array<std::array<std::int32_t, 2>, 2>> edges;
    for (const auto& triangle : h.triangles) {
      const Places places = places_of(triangle.corner, h.vertices);
      own.insert(places);
      for (const auto& [i, k] : {std::pair{0U, 1U}, {0U, 2U}, {1U, 2U}})
        edges.insert({places[i], places[k]});
    }
    FocusDemand focus;
    focus.foci = {BoxFocus{world_box(2, 2, 6, 6)}};
    focus.inside = 0.01;
    focus.outside = 200;
    const auto tin = tin_of_demand(h, built.model.chains, built.grid, focus);
    ASSERT_TRUE(tin);
    for (std::size_t t = 0; t < tin->triangles.size(); ++t) {
      const auto& corner = tin->triangles[t];
      if (own.contains(places_of(corner, tin->vertices))) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto at = [&](std::size_t k) {
          const std::uint32_t v = corner[(i + k) % 3];
          return Place{tin->vertices[v], tin->heights[v]};
        };
        std::array<std::array<std::int32_t, 2>, 2> edge{};
        for (std::size_t k = 0; k < 2; ++k) edge[k] = {at(k).at.x, at(k).at.y};
        std::ranges::sort(edge);
        if (edges.contains(edge)) continue;
        ++n_edges;
        EXPECT_LE(worst_crossing(built.grid, at(0), at(1)).error,
                  static_cast<double>(tin->errors[t]));
      }
    }
  }
  EXPECT_GT(n_edges, 50);
}

TEST(hierarchical_delaunay, varies_from_the_first_level_to_the_last) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const Built built = build(c.grid);
    const Hierarchy& h = built.model.hierarchy;
    const auto first =
        tin_of_demand(built.model.hierarchy, built.model.chains, built.grid, Demand());
    const auto all =
        tin_of_demand(built.model.hierarchy, built.model.chains, built.grid, uniform_demand(0));
    ASSERT_TRUE(first && all);
    EXPECT_EQ(first->triangles, tin_of_level(h, 0, delaunay::TinLinks::left_out).triangles);
    const auto finest = tin_of_level(h, h.n_levels() - 1, delaunay::TinLinks::left_out);
    EXPECT_EQ(all->triangles, finest.triangles);
    EXPECT_EQ(all->vertices, finest.vertices);
  }
}

TEST(hierarchical_delaunay, is_much_smaller_where_only_a_part_must_be_fine) {
  const HeightGrid grid = make_grid<float>(129, 129, hills_with_spikes);
  const std::array levels{100.0, 30.0, 10.0, 3.0, 1.0};
  const Built built = build(grid, levels);
  FocusDemand focus;
  focus.foci = {BoxFocus{world_box(50, 50, 66, 66)}};
  focus.inside = 1.1;
  focus.outside = 100.1;
  const auto tin = tin_of_demand(built.model.hierarchy, built.model.chains, built.grid, focus);
  ASSERT_TRUE(tin);
  const auto finest = tin_of_level(built.model.hierarchy, 4, delaunay::TinLinks::left_out);
  EXPECT_LT(tin->triangles.size(), finest.triangles.size() / 4);
  const auto other = FineGrid::make(make_grid<float>(9, 9, hills_with_spikes));
  ASSERT_TRUE(other);
  EXPECT_FALSE(tin_of_demand(built.model.hierarchy, built.model.chains, *other, focus));
}

TEST(hierarchical_delaunay, triangulates_only_polygons) {
  const auto place = [](std::int32_t x, std::int32_t y) { return Place{{x, y}, 0}; };
  using hierarchical_delaunay::triangulate_polygon;
  const auto square = triangulate_polygon({place(0, 0), place(4, 0), place(4, 4), place(0, 4)});
  ASSERT_TRUE(square);
  EXPECT_EQ(square->triangles.size(), 2U);
  // Turning right, with sides that cross, with a corner on a side, and twice in one place.
  EXPECT_FALSE(triangulate_polygon({place(0, 0), place(0, 4), place(4, 4), place(4, 0)}));
  EXPECT_FALSE(triangulate_polygon({place(0, 0), place(4, 4), place(4, 0), place(0, 4)}));
  EXPECT_FALSE(triangulate_polygon({place(0, 0), place(8, 0), place(4, 0), place(0, 4)}));
  EXPECT_FALSE(triangulate_polygon({place(0, 0), place(4, 0), place(4, 0), place(0, 4)}));
}

}  // namespace
}  // namespace lode::test
