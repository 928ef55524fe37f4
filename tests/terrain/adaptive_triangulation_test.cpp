// The five rules, and what they do to edges.
#include <algorithm>
#include <set>

#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/triangle_hierarchy/edge_profile.h"
#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"
#include "tests/terrain/hierarchy_fixtures.h"

namespace lode::test {
namespace {

using adaptive_triangulation::Insertion;
using adaptive_triangulation::Rule;
using adaptive_triangulation::Split;
using triangle_hierarchy::Crossings;
using triangle_hierarchy::EdgeSplit;
using triangle_hierarchy::FineGrid;
using triangle_hierarchy::Place;

const std::array<LatticePoint, 3> kCorners{{{0, 0}, {12, 0}, {0, 12}}};
const std::array<LatticePoint, 3> kMiddles{{{6, 0}, {6, 6}, {0, 6}}};

/// Twice the areas of a split's triangles, all of which turn left.
std::int64_t area_of(const Split& split, const Insertion& insertion) {
  std::array<LatticePoint, 7> places;
  for (std::size_t i = 0; i < 3; ++i) {
    places[i] = insertion.corner[i];
    places[3 + i] = insertion.on_edge[i].value_or(LatticePoint{});
  }
  places[6] = insertion.centre.value_or(LatticePoint{});
  std::int64_t sum = 0;
  for (std::size_t t = 0; t < split.n_triangles; ++t) {
    const auto& [a, b, c] = split.triangles[t];
    const std::int64_t area = delaunay::doubled_area(places[a], places[b], places[c]);
    EXPECT_GT(area, 0);
    sum += area;
  }
  return sum;
}

TEST(adaptive_splitting, follows_figure_15_on_all_edges) {
  for (unsigned mask = 0; mask < 16; ++mask) {
    Insertion insertion{.corner = kCorners, .on_edge = {}, .centre = {}};
    std::size_t n_edges = 0;
    for (std::size_t i = 0; i < 3; ++i)
      if ((mask >> i & 1) != 0) {
        insertion.on_edge[i] = kMiddles[i];
        ++n_edges;
      }
    const bool has_centre = (mask & 8) != 0;
    if (has_centre) insertion.centre = LatticePoint{3, 4};
    if (mask == 0) continue;
    const auto split = split_triangle(insertion);
    ASSERT_TRUE(split);
    const Rule one = has_centre ? Rule::edge_and_centre : Rule::edge;
    const std::array rules{Rule::centre, one, Rule::two_edges, Rule::three_edges};
    EXPECT_EQ(split->rule, rules[n_edges]);
    const std::array<std::size_t, 4> counts{3, has_centre ? 4U : 2U, 3, 4};
    EXPECT_EQ(split->n_triangles, counts[n_edges]);
    EXPECT_EQ(area_of(*split, insertion), 144);
  }
}

TEST(adaptive_splitting, joins_the_place_that_is_closer_to_its_opposite_corner) {
  const Insertion insertion{
      .corner = kCorners, .on_edge = {LatticePoint{1, 0}, LatticePoint{6, 6}, {}}, .centre = {}};
  const auto split = split_triangle(insertion);
  ASSERT_TRUE(split);
  // From the middle of edge 1, number 4, to corner 0: 72 < 145.
  for (std::size_t t = 1; t < 3; ++t) {
    const auto& triangle = split->triangles[t];
    EXPECT_TRUE(std::ranges::count(triangle, 4) == 1 && std::ranges::count(triangle, 0) == 1);
  }
}

TEST(adaptive_splitting, turns_no_triangle_over) {
  // Places next to the edge from (0, 0) to (12, 0), outside and inside.
  Insertion insertion{
      .corner = kCorners, .on_edge = {LatticePoint{6, -1}, {}, {}}, .centre = LatticePoint{3, 4}};
  auto split = split_triangle(insertion);
  ASSERT_TRUE(split);
  EXPECT_EQ(split->rule, Rule::edge_and_centre);
  EXPECT_EQ(area_of(*split, insertion), 144 + 12);
  // The centre is on the wrong side of what comes of the edge: it waits.
  insertion.on_edge[0] = LatticePoint{6, 1};
  insertion.centre = LatticePoint{10, 1};
  insertion.corner = {{{0, 0}, {12, 0}, {12, 12}}};
  insertion.on_edge[0] = LatticePoint{8, 4};
  insertion.centre = LatticePoint{9, 2};
  split = split_triangle(insertion);
  ASSERT_TRUE(split);
  EXPECT_EQ(split->rule, Rule::edge);
  // No way at all: the place is beyond the opposite corner.
  insertion.corner = {{{0, 0}, {12, 0}, {6, 1}}};
  insertion.on_edge[0] = LatticePoint{6, 1};
  insertion.centre.reset();
  EXPECT_FALSE(split_triangle(insertion));
}

TEST(adaptive_triangulation, uses_all_five_rules) {
  Progress progress;
  const auto made = adaptive_triangulation::build(terrain_cases()[0].grid, kLevels, {2}, progress);
  ASSERT_TRUE(made);
  for (const std::uint64_t n : made->n_splits) EXPECT_GT(n, 0U);
}

/// The largest error of an edge where it crosses columns and rows, from the definition.
long double profile_error(const FineGrid& grid, const Place& a, const Place& b) {
  const auto scale = static_cast<long double>(grid.scale());
  const std::array<long double, 2> from{a.at.x / scale, a.at.y / scale};
  const std::array<long double, 2> along{b.at.x / scale - from[0], b.at.y / scale - from[1]};
  long double worst = 0;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const long double low = std::min(from[axis], from[axis] + along[axis]);
    const long double high = std::max(from[axis], from[axis] + along[axis]);
    for (auto k = static_cast<std::int32_t>(std::floor(low)) + 1; k < high; ++k) {
      const long double share = (k - from[axis]) / along[axis];
      const long double other = from[1 - axis] + along[1 - axis] * share;
      const auto i = static_cast<std::int32_t>(std::floor(other));
      const long double part = other - i;
      const auto sample = [&](std::int32_t at) -> long double {
        return axis == 0 ? grid.sample(k, at) : grid.sample(at, k);
      };
      const long double height =
          part == 0 ? sample(i) : (1 - part) * sample(i) + part * sample(i + 1);
      worst = std::max(worst, std::abs(height - ((1 - share) * a.height + share * b.height)));
    }
  }
  return worst;
}

TEST(adaptive_triangulation, keeps_tolerances_along_edges_between_samples) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    Progress progress;
    const auto made = adaptive_triangulation::build(c.grid, kLevels, {2}, progress);
    ASSERT_TRUE(made);
    const Hierarchy& h = made->hierarchy;
    const auto grid = FineGrid::make(c.grid);
    ASSERT_TRUE(grid);
    std::uint64_t n_beyond = 0;
    for (int level = 0; level < h.n_levels(); ++level) {
      const double limit = kLevels[static_cast<std::size_t>(level)] + rounding_of(c.grid);
      const delaunay::Tin tin = tin_of_level(h, level, delaunay::TinLinks::left_out);
      std::set<std::pair<std::uint32_t, std::uint32_t>> beyond;
      for (const auto& t : tin.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
          const auto [a, b] = std::minmax(t[i], t[(i + 1) % 3]);
          if (profile_error(*grid, {tin.vertices[a], tin.heights[a]},
                            {tin.vertices[b], tin.heights[b]}) > limit)
            beyond.insert({a, b});
        }
      n_beyond += beyond.size();
    }
    EXPECT_LE(n_beyond, made->n_edges_left);
  }
}

TEST(edge_profiles, are_those_of_the_definition_from_both_ends) {
  oracles::Random random(12);
  for (const TerrainCase& c : terrain_cases()) {
    if (c.grid.n_missing() > 0) continue;
    SCOPED_TRACE(c.name);
    const auto grid = FineGrid::make(c.grid);
    ASSERT_TRUE(grid);
    const auto any_place = [&] {
      // On a column or on a row, at samples, and between them.
      const auto below = [&](std::int64_t n) {
        return static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(n)));
      };
      LatticePoint at = grid->fine({below(c.grid.n_columns - 1), below(c.grid.n_rows - 1)});
      const int kind = below(3);
      if (kind == 0) at.x += below(grid->scale());
      if (kind == 1) at.y += below(grid->scale());
      return Place{at, grid->height(at)};
    };
    for (int n = 0; n < 200; ++n) {
      const Place a = any_place();
      const Place b = any_place();
      const EdgeSplit split = worst_crossing(*grid, a, b);
      EXPECT_NEAR(split.error, static_cast<double>(profile_error(*grid, a, b)),
                  rounding_of(c.grid));
      const EdgeSplit back = worst_crossing(*grid, b, a);
      EXPECT_EQ(split.error, back.error);
      EXPECT_EQ(split.place.at, back.place.at);
      EXPECT_EQ(split.place.height, back.place.height);
      EXPECT_LE(worst_crossing(*grid, a, b, Crossings::exact).error, split.error);
      if (split.error == 0) continue;
      // On a column or row, half a node off at most, and exact where it says so.
      const LatticePoint p = split.place.at;
      EXPECT_TRUE(p.x % grid->scale() == 0 || p.y % grid->scale() == 0);
      const std::int64_t off = std::abs(delaunay::doubled_area(a.at, b.at, p));
      EXPECT_EQ(split.is_exact, off == 0);
      EXPECT_LE(2 * off, std::max(std::abs(b.at.x - a.at.x), std::abs(b.at.y - a.at.y)));
    }
  }
}

}  // namespace
}  // namespace lode::test
