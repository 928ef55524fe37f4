// The six patterns of the restricted quadtree, as figure 11 of the survey has them.
#include <algorithm>
#include <array>
#include <bit>
#include <set>
#include <vector>

#include "lode/models/terrain/restricted_quadtree/pattern.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode {
namespace {

using delaunay::LatticePoint;
using restricted_quadtree::SideMask;
using squares::Square;

/// Places in a square of side 2, by column and row; each triangle turns left.
using PatternTriangle = std::array<std::array<std::int32_t, 2>, 3>;

struct Pattern {
  const char* name;
  SideMask midpoints;  ///< Lower, right, upper, left.
  std::vector<PatternTriangle> triangles;
};

/// By which neighbours are smaller; any other choice of sides is one of these, turned.
std::vector<Pattern> six_patterns() {
  constexpr std::array<std::int32_t, 2> kCentre{1, 1};
  const PatternTriangle lower{{{0, 0}, {2, 0}, kCentre}};
  const PatternTriangle right{{{2, 0}, {2, 2}, kCentre}};
  const PatternTriangle upper{{{2, 2}, {0, 2}, kCentre}};
  const PatternTriangle left{{{0, 2}, {0, 0}, kCentre}};
  const PatternTriangle lower_left{{{0, 0}, {1, 0}, kCentre}};
  const PatternTriangle lower_right{{{1, 0}, {2, 0}, kCentre}};
  const PatternTriangle right_low{{{2, 0}, {2, 1}, kCentre}};
  const PatternTriangle right_high{{{2, 1}, {2, 2}, kCentre}};
  const PatternTriangle upper_right{{{2, 2}, {1, 2}, kCentre}};
  const PatternTriangle upper_left{{{1, 2}, {0, 2}, kCentre}};
  const PatternTriangle left_high{{{0, 2}, {0, 1}, kCentre}};
  const PatternTriangle left_low{{{0, 1}, {0, 0}, kCentre}};
  return {
      {"none", 0b0000, {lower, right, upper, left}},
      {"one", 0b0001, {lower_left, lower_right, right, upper, left}},
      {"two side by side", 0b0011, {lower_left, lower_right, right_low, right_high, upper, left}},
      {"two across", 0b0101, {lower_left, lower_right, right, upper_right, upper_left, left}},
      {"three",
       0b0111,
       {lower_left, lower_right, right_low, right_high, upper_right, upper_left, left}},
      {"all",
       0b1111,
       {lower_left, lower_right, right_low, right_high, upper_right, upper_left, left_high,
        left_low}}};
}

/// A quarter turn to the left: what was below is on the right.
Pattern turned(Pattern pattern) {
  pattern.midpoints =
      static_cast<SideMask>((pattern.midpoints << 1 | pattern.midpoints >> 3) & 0b1111);
  for (PatternTriangle& triangle : pattern.triangles)
    for (auto& [x, y] : triangle) {
      const std::int32_t old = x;
      x = 2 - y;
      y = old;
    }
  return pattern;
}

using Corners = std::array<std::pair<std::int32_t, std::int32_t>, 3>;

/// From its least corner on.
Corners from_least(Corners corners) {
  std::ranges::rotate(corners, std::ranges::min_element(corners));
  return corners;
}

std::set<Corners> placed(const Pattern& pattern, const Square& square) {
  std::set<Corners> all;
  const std::int32_t half = square.side() / 2;
  for (const PatternTriangle& triangle : pattern.triangles) {
    Corners corners;
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] = {square.x() + triangle[i][0] * half, square.y() + triangle[i][1] * half};
    all.insert(from_least(corners));
  }
  return all;
}

/// All choices of sides.
std::vector<Pattern> all_patterns() {
  std::vector<Pattern> all;
  for (Pattern pattern : six_patterns())
    for (int i = 0; i < 4; ++i) {
      const bool is_new = std::ranges::none_of(
          all, [&](const Pattern& other) { return other.midpoints == pattern.midpoints; });
      if (is_new) all.push_back(pattern);
      pattern = turned(pattern);
    }
  return all;
}

TEST(restricted_quadtree, has_the_six_patterns_of_the_survey_and_no_others) {
  const std::vector<Pattern> all = all_patterns();
  ASSERT_EQ(all.size(), 16U);
  const Square square{3, 5, 2};
  for (const Pattern& pattern : all) {
    SCOPED_TRACE(testing::Message() << pattern.name << ", " << int{pattern.midpoints});
    std::set<Corners> made;
    restricted_quadtree::visit_pattern(
        square, pattern.midpoints, [&](LatticePoint a, LatticePoint b, LatticePoint c) {
          EXPECT_GT(delaunay::doubled_area(a, b, c), 0);
          made.insert(from_least({std::pair{a.x, a.y}, {b.x, b.y}, {c.x, c.y}}));
        });
    EXPECT_EQ(made, placed(pattern, square));
    EXPECT_EQ(made.size(), 4U + static_cast<unsigned>(std::popcount(pattern.midpoints)));
  }
}

constexpr Square kSubject{2, 4, 4};

/// Level, but for spikes in the middle of quarters: in neighbours of the subject, which they split
/// once, and in the square diagonally across, so that the subject is one whatever its neighbours
/// are.
HeightGrid spikes_beside_subject(SideMask neighbours) {
  std::vector<LatticePoint> spikes{{21, 21}};
  constexpr std::array<LatticePoint, 4> kBeside{{{17, 13}, {21, 17}, {17, 21}, {13, 17}}};
  for (std::size_t side = 0; side < 4; ++side)
    if ((neighbours >> side & 1) != 0) spikes.push_back(kBeside[side]);
  return delaunay::test::make_grid<std::int16_t>(33, 33, [&](int x, int y) {
    return std::ranges::any_of(spikes, [&](LatticePoint p) { return p.x == x && p.y == y; }) ? 100
                                                                                             : 0;
  });
}

TEST(restricted_quadtree, cuts_a_square_by_which_neighbours_are_smaller) {
  for (const Pattern& pattern : all_patterns()) {
    SCOPED_TRACE(testing::Message() << pattern.name << ", " << int{pattern.midpoints});
    const auto domain = squares::SquareDomain::make(spikes_beside_subject(pattern.midpoints));
    ASSERT_TRUE(domain);
    Progress progress;
    const auto leaves = restricted_quadtree::build(*domain, 1, progress);
    ASSERT_TRUE(leaves);
    const auto own = std::ranges::find(*leaves, kSubject, &restricted_quadtree::Leaf::square);
    ASSERT_NE(own, leaves->end());
    EXPECT_EQ(int{own->midpoints}, int{pattern.midpoints});
    // Its triangles are those of the mesh whose centres are in it.
    const delaunay::Tin tin = restricted_quadtree::to_tin(*domain, *leaves);
    std::set<Corners> inside;
    for (const auto& t : tin.triangles) {
      Corners corners;
      std::int32_t x = 0;
      std::int32_t y = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        corners[i] = {tin.vertices[t[i]].x, tin.vertices[t[i]].y};
        x += corners[i].first - kSubject.x();
        y += corners[i].second - kSubject.y();
      }
      if (std::min(x, y) > 0 && std::max(x, y) < 3 * kSubject.side())
        inside.insert(from_least(corners));
    }
    EXPECT_EQ(inside, placed(pattern, kSubject));
  }
}

}  // namespace
}  // namespace lode
