#include "lode/locate/tin_neighbours.h"

#include <gtest/gtest.h>

#include "lode/locate/tin_locator.h"
#include "tests/locate/edge_pairs.h"
#include "tests/locate/tin_fixtures.h"

namespace lode::test {
namespace {

void expect_pairs(const std::string& name, const Tin& tin, std::int32_t period = 0) {
  const EdgePairs pairs = pair_by_trying(tin, period);
  const TinNeighbours neighbours(tin, period);
  for (std::uint32_t t = 0; t < tin.triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const auto beside = neighbours.beside(t, i);
      ASSERT_EQ(beside.size(), pairs[t][i].size()) << name << ' ' << t << ' ' << i;
      for (std::size_t k = 0; k < beside.size(); ++k) {
        EXPECT_EQ(beside[k].triangle, pairs[t][i][k].triangle) << name << ' ' << t << ' ' << i;
        EXPECT_EQ(beside[k].edge, pairs[t][i][k].edge) << name << ' ' << t << ' ' << i;
      }
    }
}

/// A square of side 4 beside two of side 2, and beside these one of side 4 in two triangles; above,
/// after a gap, nothing meets.
Tin squares_that_hang() {
  Tin tin;
  tin.vertices = {{0, 0}, {4, 0}, {6, 0}, {10, 0}, {4, 2}, {6, 2},
                  {0, 4}, {4, 4}, {6, 4}, {10, 4}, {0, 5}, {4, 5}};
  tin.triangles = {{0, 1, 7}, {0, 7, 6}, {1, 2, 5}, {1, 5, 4},  {4, 5, 8},
                   {4, 8, 7}, {2, 3, 9}, {2, 9, 8}, {10, 6, 7}, {10, 7, 11}};
  return tin;
}

TEST(tin_neighbours, are_all_that_share_an_edge_with_twins_and_without) {
  for (GridTin& one : all_tins()) {
    expect_pairs(one.name, one.tin);
    one.tin.twins.clear();
    expect_pairs(one.name + " without twins", one.tin);
  }
}

TEST(tin_neighbours, are_several_where_vertices_hang_in_an_edge) {
  const Tin tin = squares_that_hang();
  expect_pairs("squares", tin);
  const TinNeighbours neighbours(tin);
  using Beside = TinNeighbours::Beside;
  // Up along the right side of the first square; down along the left one of the last.
  EXPECT_EQ(neighbours.beside(0, 1), (std::vector<Beside>{{3, 2}, {5, 2}}));
  EXPECT_EQ(neighbours.beside(7, 2), (std::vector<Beside>{{4, 1}, {2, 1}}));
  EXPECT_EQ(neighbours.beside(3, 2), (std::vector<Beside>{{0, 1}}));
  EXPECT_TRUE(neighbours.beside(0, 0).empty());
}

TEST(tin_neighbours, go_round_where_two_columns_are_one) {
  Tin tin = squares_that_hang();
  expect_pairs("round", tin, 10);
  // Half of the last column's side has the square's, all of it; and the one above has nothing.
  EXPECT_EQ(TinNeighbours(tin, 10).beside(6, 1), (std::vector<TinNeighbours::Beside>{{1, 2}}));
  for (GridTin& one : all_tins())
    expect_pairs(one.name + ", round", one.tin, one.grid.n_columns - 1);
}

TEST(tin_neighbours, come_in_rings_of_as_many_steps) {
  for (const GridTin& one : all_tins()) {
    const EdgePairs pairs = pair_by_trying(one.tin);
    const TinNeighbours neighbours(one.tin);
    const TinLocator locator(one.tin);
    for (const Point& p : hard_places(one, 9, 3)) {
      const std::vector<std::uint32_t> start = locator.find_all(p);
      const std::vector<std::uint32_t> steps = steps_from(pairs, start);
      for (const std::uint32_t n_rings : {0U, 1U, 2U, 7U, 1000'000'000U}) {
        std::vector<RingTriangle> wanted;
        for (std::uint32_t t = 0; t < steps.size(); ++t)
          if (steps[t] <= n_rings) wanted.push_back({t, steps[t]});
        std::ranges::stable_sort(wanted, {}, &RingTriangle::ring);
        EXPECT_EQ(neighbours.rings(start, n_rings), wanted) << one.name;
      }
    }
  }
}

TEST(tin_locator, finds_all_triangles_that_hold_a_place) {
  for (const GridTin& one : all_tins()) {
    const TinLocator locator(one.tin);
    std::size_t most = 0;
    for (const Point& p : hard_places(one, 8, 60)) {
      std::vector<std::uint32_t> all;
      for (std::uint32_t t = 0; t < one.tin.triangles.size(); ++t)
        if (holds_exactly(one.tin, t, p)) all.push_back(t);
      EXPECT_EQ(locator.find_all(p), all) << one.name << ' ' << p[0] << ' ' << p[1];
      most = std::max(most, all.size());
    }
    EXPECT_GE(most, 2U) << one.name;
  }
}

}  // namespace
}  // namespace lode::test
