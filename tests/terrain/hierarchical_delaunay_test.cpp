// Chains, and Delaunay refinements.
#include <algorithm>
#include <array>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/models/terrain/triangle_hierarchy/edge_chains.h"
#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"
#include "lode/models/terrain/triangle_hierarchy/polygon.h"
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
    const auto chains = triangle_hierarchy::EdgeChains::find_in(h);
    ASSERT_TRUE(chains);
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
        const auto found = chains->find(corner[i], to);
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

TEST(hierarchical_delaunay, triangulates_only_polygons) {
  const auto place = [](std::int32_t x, std::int32_t y) { return Place{{x, y}, 0}; };
  using triangle_hierarchy::triangulate_polygon;
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
