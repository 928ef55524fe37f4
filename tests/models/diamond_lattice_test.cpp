// The facts of docs/models/diamond3d.md, by enumeration on small lattices.
#include "lode/models/diamond/lattice.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace lode::diamond {
namespace {

template <int D>
bool is_in_cube(const Index<D>& p, std::int32_t side) {
  return std::all_of(p.v.begin(), p.v.end(), [&](std::int32_t c) { return c >= 0 && c <= side; });
}

/// Bisects everything down to unit cells and counts, per centre, the simplices bisected there.
template <int D>
void bisect_all(const Simplex<D>& s, std::map<Index<D>, int>& simplices_of) {
  Index<D> lower = s.v[0];
  Index<D> upper = s.v[0];
  for (const Index<D>& v : s.v)
    for (std::size_t i = 0; i < as_size(D); ++i) {
      lower[i] = std::min(lower[i], v[i]);
      upper[i] = std::max(upper[i], v[i]);
    }
  if (s.tag == D && upper[0] - lower[0] == 1) return;
  const Diamond<D> d = diamond_at<D>(s.bisection_point());
  const auto ends = axis_ends<D>(d);
  const std::set<Index<D>> expected{ends[0], ends[1]};
  const std::set<Index<D>> axis{s.v[0], s.v[as_size(s.tag)]};
  EXPECT_EQ(axis, expected);
  EXPECT_EQ(D - d.tier, s.tag);
  ++simplices_of[d.centre];
  for (const Simplex<D>& half : bisect(s)) bisect_all(half, simplices_of);
}

template <int D>
std::map<Index<D>, int> all_diamonds(std::int32_t side) {
  std::map<Index<D>, int> simplices_of;
  for (const Simplex<D>& s : kuhn_simplices<D>({}, side)) bisect_all<D>(s, simplices_of);
  return simplices_of;
}

TEST(diamond_lattice, makes_every_point_but_the_corners_the_centre_of_one_diamond) {
  EXPECT_EQ(all_diamonds<3>(16).size(), 17U * 17U * 17U - 8U);
  EXPECT_EQ(all_diamonds<2>(16).size(), 17U * 17U - 4U);
}

TEST(diamond_lattice, has_the_papers_counts_of_simplices_parents_and_children) {
  constexpr std::int32_t kSide = 16;
  const int n_simplices[3] = {6, 4, 8};
  const std::size_t n_parents[3] = {3, 2, 4};
  const std::size_t n_children[3] = {6, 4, 8};
  for (const auto& [centre, n] : all_diamonds<3>(kSide)) {
    const Diamond<3> d = diamond_at<3>(centre);
    Index<3> low = centre;
    Index<3> high = centre;
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] -= d.h();
      high[i] += d.h();
    }
    if (!is_in_cube<3>(low, kSide) || !is_in_cube<3>(high, kSide)) continue;
    const auto tier = as_size(d.tier);
    EXPECT_EQ(n, n_simplices[tier]);
    if (2 * d.h() < kSide) EXPECT_EQ(parents<3>(d, kSide).size(), n_parents[tier]);
    if (d.level > 0 || d.tier < 2) EXPECT_EQ(children<3>(d).size(), n_children[tier]);
  }
}

TEST(diamond_lattice, makes_parents_and_children_each_others_inverse) {
  constexpr std::int32_t kSide = 16;
  for (const auto& [centre, n] : all_diamonds<3>(kSide)) {
    const Diamond<3> d = diamond_at<3>(centre);
    for (const Index<3>& child : children<3>(d)) {
      if (!is_in_cube<3>(child, kSide)) continue;
      const auto back = parents<3>(diamond_at<3>(child), kSide);
      EXPECT_NE(std::find(back.begin(), back.end(), centre), back.end());
    }
  }
}

/// Every simplex that has samples on both sides of the last one is bisected at a node that knows.
template <int D>
void expect_known_across(const Shape<D>& shape, const Simplex<D>& s) {
  const LatticeBox<D> box = bounds_of(s);
  if (s.tag == D && box.edge(0) == 1) return;
  const Diamond<D> d = diamond_at<D>(s.bisection_point());
  for (std::size_t i = 0; i < as_size(D); ++i)
    if (box.lower[i] < shape.dims[i] - 1 && shape.dims[i] - 1 < box.upper[i])
      EXPECT_TRUE(shape.reaches_across(d.centre, d.level));
  for (const Simplex<D>& half : bisect(s)) expect_known_across(shape, half);
}

template <int D>
void expect_nested_across(const Index<D>& dims) {
  const Shape<D> shape = Shape<D>::of(dims);
  for (const Simplex<D>& s : kuhn_simplices<D>({}, shape.root_side()))
    expect_known_across(shape, s);
  for (const auto& [centre, n] : all_diamonds<D>(shape.root_side())) {
    const Diamond<D> d = diamond_at<D>(centre);
    if (!shape.reaches_across(d.centre, d.level)) continue;
    for (const Index<D>& parent : parents<D>(d, shape.root_side()))
      EXPECT_TRUE(shape.reaches_across(parent, diamond_at<D>(parent).level));
  }
}

TEST(diamond_lattice, knows_nodes_that_reach_across_the_border_and_so_do_their_parents) {
  for (std::int32_t n = 2; n <= 17; ++n) {
    expect_nested_across<3>({{n, 17, 12}});
    expect_nested_across<3>({{5, n, 16}});
    expect_nested_across<2>({{n, 30}});
    expect_nested_across<2>({{33, 2 * n}});
  }
}

TEST(diamond_lattice, has_no_cube_across_the_border_that_does_not_hold_it) {
  const Shape<3> shape = Shape<3>::of({{17, 9, 17}});
  for (const auto& [centre, n] : all_diamonds<3>(16)) {
    const int level = diamond_at<3>(centre).level;
    EXPECT_EQ(shape.reaches_across(centre, level), level == 3);
  }
}

}  // namespace
}  // namespace lode::diamond
