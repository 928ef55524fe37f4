#include "lode/delaunay/full_tin.h"

#include <gtest/gtest.h>

#include "lode/delaunay/grid_domain.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode::delaunay::test {
namespace {

int lumpy(std::int32_t x, std::int32_t y) { return (x * 7919 + y * 104729) % 97; }

std::vector<HeightGrid> domains() {
  std::vector<HeightGrid> grids{make_grid<std::int16_t>(2, 2, lumpy), make_grid<float>(9, 2, lumpy),
                                make_grid<double>(23, 17, lumpy),
                                make_grid<std::int16_t>(40, 31, lumpy)};
  for (std::int32_t y = 0; y < 31; ++y)
    for (std::int32_t x = 0; x < 40; ++x)
      if ((x * 31 + y * 17) % 23 == 0 || x > y + 20) set_missing(grids.back(), x, y);
  return grids;
}

TEST(full_tin, fills_the_domain_with_all_its_samples_and_is_delaunay) {
  for (const HeightGrid& grid : domains()) {
    const auto full = to_full_tin(grid);
    const auto domain = find_domain(grid);
    ASSERT_TRUE(full);
    ASSERT_TRUE(domain);
    expect_fills(full->tin, grid);
    expect_locally_delaunay(full->tin);
    EXPECT_EQ(full->tin.triangles.size(), 2 * domain->n_cells);
    EXPECT_EQ(full->tin.vertices.size(), domain->n_samples);
    EXPECT_EQ(full->n_left_out, domain->n_left_out);
    EXPECT_EQ(largest_error(full->tin, grid), 0);
    for (std::size_t v = 0; v < full->tin.vertices.size(); ++v)
      EXPECT_EQ(full->tin.heights[v], lumpy(full->tin.vertices[v].x, full->tin.vertices[v].y));
  }
}

TEST(full_tin, links_what_shares_an_edge) {
  for (const HeightGrid& grid : domains()) {
    const auto full = to_full_tin(grid);
    ASSERT_TRUE(full);
    const Tin& tin = full->tin;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edges;
    for (std::uint32_t t = 0; t < tin.triangles.size(); ++t)
      for (std::uint32_t i = 0; i < 3; ++i)
        edges[{tin.triangles[t][i], tin.triangles[t][(i + 1) % 3]}] = 4 * t + i;
    for (const auto& [ends, half_edge] : edges) {
      const auto other = edges.find({ends.second, ends.first});
      EXPECT_EQ(tin.twins[half_edge / 4][half_edge % 4],
                other == edges.end() ? kNoHalfEdge : other->second);
    }
  }
}

TEST(full_tin, cuts_cells_where_heights_differ_less) {
  // Level from the lower right to the upper left, a slope the other way.
  const auto slope = to_full_tin(make_grid<float>(2, 2, [](auto x, auto y) { return x + y; }));
  ASSERT_TRUE(slope);
  EXPECT_EQ(slope->tin.triangles[0], (Corners{0, 1, 2}));
  const auto level = to_full_tin(make_grid<float>(2, 2, [](auto x, auto y) { return x == y; }));
  ASSERT_TRUE(level);
  EXPECT_EQ(level->tin.triangles[0], (Corners{0, 1, 3})) << "of equal ones from the lower left";
}

TEST(full_tin, refuses_grids_without_cells) {
  EXPECT_FALSE(to_full_tin(make_grid<float>(1, 1, lumpy)));
  EXPECT_FALSE(to_full_tin(make_grid<float>(9, 1, lumpy)));
  HeightGrid empty = make_grid<float>(3, 3, lumpy);
  for (std::int32_t i = 0; i < 9; ++i) set_missing(empty, i % 3, i / 3);
  EXPECT_FALSE(to_full_tin(empty));
}

}  // namespace
}  // namespace lode::delaunay::test
