// Quadtrees over rasters of any size, with and without gaps in their heights.
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>

#include "lode/mappers/tin_gaps.h"
#include "lode/mappers/tin_window.h"
#include "lode/models/terrain/quaternary_triangulation/quaternary_triangulation.h"
#include "lode/models/terrain/restricted_quadtree/restricted_quadtree.h"
#include "lode/models/terrain/surface_quadtree/surface_quadtree.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode {
namespace {

using delaunay::Tin;
using delaunay::test::make_grid;
using squares::Square;
using squares::SquareDomain;

constexpr auto hills = delaunay::test::spiky_hills;

struct Case {
  const char* name;
  HeightGrid grid;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"a power of two and one", make_grid<std::int16_t>(33, 33, hills)});
  all.push_back({"odd", make_grid<float>(45, 22, hills)});
  all.push_back({"a strip", make_grid<std::int16_t>(2, 40, hills)});
  all.push_back({"a cell", make_grid<double>(2, 2, hills)});
  // Differences of these heights are not what float64 makes of them.
  all.push_back({"rounded", make_grid<double>(21, 19, [](int x, int y) {
                   return std::exp2(y % 5 * 9) * std::sin(0.7 * x + y) / 3;
                 })});
  all.push_back({"flat", make_grid<float>(40, 17, [](int, int) { return 7; })});
  Case gaps{"gaps", make_grid<std::int16_t>(38, 41, hills)};
  for (std::int32_t y = 10; y < 17; ++y)
    for (std::int32_t x = 5; x < 9 + y / 2; ++x) delaunay::test::set_missing(gaps.grid, x, y);
  delaunay::test::set_missing(gaps.grid, 0, 40);
  delaunay::test::set_missing(gaps.grid, 30, 30);
  all.push_back(std::move(gaps));
  return all;
}

constexpr std::array kTolerances{1000.0, 150.0, 40.0, 7.0, 0.5, 0.0};

SquareDomain domain_of(const HeightGrid& grid) {
  auto domain = SquareDomain::make(grid);
  EXPECT_TRUE(domain);
  return *std::move(domain);
}

/// Triangles turn left and cover all cells with four heights once, whether or not they meet.
void expect_covers(const Tin& tin, const HeightGrid& grid) {
  std::int64_t area = 0;
  for (const auto& t : tin.triangles) {
    const auto own =
        delaunay::doubled_area(tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]]);
    EXPECT_GT(own, 0);
    area += own;
  }
  std::int64_t n_cells = 0;
  for (std::int32_t y = 0; y + 1 < grid.n_rows; ++y)
    for (std::int32_t x = 0; x + 1 < grid.n_columns; ++x)
      if (delaunay::test::has_cell(grid, x, y)) ++n_cells;
  EXPECT_EQ(area, 2 * n_cells);
}

/// Bilinear between its corners, from the definition, in long doubles.
long double largest_bilinear_error(const Square& q, const HeightGrid& grid) {
  const auto z = [&](int i, int j) -> long double {
    return grid.height(q.x() + i * q.side(), q.y() + j * q.side());
  };
  long double worst = 0;
  for (std::int32_t v = 0; v <= q.side(); ++v)
    for (std::int32_t u = 0; u <= q.side(); ++u) {
      const long double s = static_cast<long double>(u) / q.side();
      const long double t = static_cast<long double>(v) / q.side();
      const long double surface = (1 - s) * (1 - t) * z(0, 0) + s * (1 - t) * z(1, 0) +
                                  (1 - s) * t * z(0, 1) + s * t * z(1, 1);
      worst = std::max(worst, std::abs(surface - grid.height(q.x() + u, q.y() + v)));
    }
  return worst;
}

/// Counting stops at one more than is asked for.
template <typename Tree>
void expect_counted(const Tree& tree, double tolerance, std::uint64_t n) {
  EXPECT_EQ(tree.count_leaves(tolerance, n), n);
  EXPECT_EQ(tree.count_leaves(tolerance, n + 1000), n);
  if (n > 0) EXPECT_EQ(tree.count_leaves(tolerance, n - 1), n);
  if (n > 3) EXPECT_EQ(tree.count_leaves(tolerance, 2), 3U);
}

TEST(surface_quadtree, is_the_same_from_below_and_from_above) {
  for (const Case& c : cases()) {
    Progress progress;
    const auto tree = surface_quadtree::SurfaceQuadtree::build(c.grid, {2}, progress);
    ASSERT_TRUE(tree);
    for (const double tolerance : kTolerances) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      const auto leaves = tree->leaves(tolerance);
      expect_counted(*tree, tolerance, leaves.size());
      EXPECT_EQ(leaves, surface_quadtree::leaves_top_down(tree->domain(), tolerance));
      for (const Square& leaf : leaves) {
        EXPECT_LE(static_cast<double>(largest_bilinear_error(leaf, c.grid)), tolerance);
        // It is minimal: what holds a leaf does not keep the tolerance, or is not in the domain.
        const Square parent{leaf.level + 1, leaf.column / 2, leaf.row / 2};
        if (tree->domain().share(parent) == squares::Share::all)
          EXPECT_GT(static_cast<double>(largest_bilinear_error(parent, c.grid)), tolerance);
      }
      expect_covers(to_tin(*tree, leaves), c.grid);
    }
  }
}

TEST(surface_quadtree, keeps_the_highest_squares_though_a_part_errs_by_more) {
  // The design's example: corners 0, centre and midpoints of sides 1, a quadrant's centre -1.
  const HeightGrid grid = make_grid<float>(5, 5, [](int x, int y) {
    if (x == 1 && y == 1) return -1.0;
    if (x % 4 == 0 && y % 4 == 0) return 0.0;
    return (x % 2 == 0 && y % 2 == 0) ? 1.0 : 0.5;
  });
  Progress progress;
  const auto tree = surface_quadtree::SurfaceQuadtree::build(grid, {1}, progress);
  ASSERT_TRUE(tree);
  EXPECT_EQ(tree->leaves(1).size(), 1U);
  EXPECT_GT(tree->error({1, 0, 0}), 1);
}

/// It is minimal: what holds a leaf does not keep the tolerance, or is not in the domain.
void expect_parent_beyond(const quaternary_triangulation::QuaternaryTriangulation& tree,
                          const quaternary_triangulation::HalfSquare& leaf, double tolerance) {
  const Square above{leaf.square.level + 1, leaf.square.column / 2, leaf.square.row / 2};
  if (above.level >= tree.domain().n_levels()) return;
  int n_parents = 0;
  for (const bool is_upper : {false, true})
    for (int i = 0; i < 4; ++i) {
      const quaternary_triangulation::HalfSquare parent{above, is_upper};
      if (parent.child(i) != leaf) continue;
      ++n_parents;
      EXPECT_GT(static_cast<double>(tree.error(parent)), tolerance);
    }
  EXPECT_EQ(n_parents, 1);
}

TEST(quaternary_triangulation, keeps_its_tolerance_and_is_minimal) {
  for (const Case& c : cases()) {
    Progress progress;
    const auto tree =
        quaternary_triangulation::QuaternaryTriangulation::build(c.grid, {2}, progress);
    ASSERT_TRUE(tree);
    std::size_t n_last = 0;
    for (const double tolerance : kTolerances) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      const auto leaves = tree->leaves(tolerance);
      expect_counted(*tree, tolerance, leaves.size());
      const Tin tin = to_tin(*tree, leaves);
      expect_covers(tin, c.grid);
      EXPECT_LE(static_cast<double>(delaunay::test::largest_error(tin, c.grid)), tolerance);
      EXPECT_GE(leaves.size(), n_last);
      n_last = leaves.size();
      for (const auto& leaf : leaves) expect_parent_beyond(*tree, leaf, tolerance);
    }
  }
}

TEST(quaternary_triangulation, splits_by_midpoints) {
  const quaternary_triangulation::HalfSquare root{{3, 0, 0}, true};
  std::vector<quaternary_triangulation::HalfSquare> children;
  for (int i = 0; i < 4; ++i) children.push_back(root.child(i));
  using quaternary_triangulation::HalfSquare;
  EXPECT_EQ(children,
            (std::vector<HalfSquare>{
                {{2, 0, 0}, true}, {{2, 0, 1}, true}, {{2, 0, 1}, false}, {{2, 1, 1}, true}}));
}

bool holds_sample(const Square& square, std::int32_t x, std::int32_t y) {
  const std::int32_t u = x - square.x();
  const std::int32_t v = y - square.y();
  return std::min(u, v) >= 0 && std::max(u, v) <= square.side();
}

bool holds_sample(const quaternary_triangulation::HalfSquare& half, std::int32_t x,
                  std::int32_t y) {
  const std::int32_t u = x - half.square.x();
  const std::int32_t v = y - half.square.y();
  return holds_sample(half.square, x, y) && (half.is_upper ? v >= u : u >= v);
}

/// Of the leaves within a tolerance.
template <typename Tree>
void expect_asked_from_above(const Tree& tree, const HeightGrid& grid, double tolerance) {
  const auto leaves = tree.leaves(tolerance);
  const Tin tin = to_tin(tree, leaves);
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x) {
      const auto found = find_leaf(tree, tolerance, {x, y});
      ASSERT_EQ(found.has_value(), tree.domain().has_node({x, y})) << x << ", " << y;
      if (!found) continue;
      EXPECT_NE(std::ranges::find(leaves, *found), leaves.end());
      EXPECT_TRUE(holds_sample(*found, x, y)) << x << ", " << y;
    }
  oracles::Random random(7);
  for (int i = 0; i < 20; ++i) {
    const auto below = [&](std::int32_t n) {
      return static_cast<std::int32_t>(random.below(static_cast<std::uint32_t>(n)));
    };
    delaunay::Window window{{below(grid.n_columns), below(grid.n_rows)}, {}};
    window.upper = {window.lower.x + below(grid.n_columns), window.lower.y + below(grid.n_rows)};
    // keep_in_window() cuts triangles with a rectangle by other means.
    Tin inside = tin;
    keep_in_window(inside, grid,
                   {{{static_cast<double>(window.lower.x), static_cast<double>(window.lower.y)}},
                    {{static_cast<double>(window.upper.x), static_cast<double>(window.upper.y)}}});
    EXPECT_EQ(count_in_window(tree, tolerance, window), inside.triangles.size());
  }
}

TEST(quadtrees, find_places_and_count_in_windows_without_a_mesh) {
  for (const Case& c : cases()) {
    Progress progress;
    auto squares = surface_quadtree::SurfaceQuadtree::build(c.grid, {2}, progress);
    auto halves = quaternary_triangulation::QuaternaryTriangulation::build(c.grid, {2}, progress);
    ASSERT_TRUE(squares && halves);
    for (const bool has_kept : {false, true}) {
      if (has_kept) {
        squares->keep({{1, 1}});
        halves->keep({{1, 1}});
      }
      for (const double tolerance : {150.0, 7.0, 0.0}) {
        SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
        expect_asked_from_above(*squares, c.grid, tolerance);
        expect_asked_from_above(*halves, c.grid, tolerance);
      }
    }
  }
}

/// Of neighbours across a side, no one's side is more than twice the other's.
void expect_balanced(const std::vector<restricted_quadtree::Leaf>& leaves, const HeightGrid& grid) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> level_of;
  for (const auto& leaf : leaves)
    for (std::int32_t y = leaf.square.y(); y < leaf.square.y() + leaf.square.side(); ++y)
      for (std::int32_t x = leaf.square.x(); x < leaf.square.x() + leaf.square.side(); ++x)
        EXPECT_TRUE(level_of.insert({{x, y}, leaf.square.level}).second);
  for (const auto& [cell, level] : level_of)
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}}) {
      const auto other = level_of.find({cell.first + dx, cell.second + dy});
      if (other != level_of.end()) EXPECT_LE(std::abs(other->second - level), 1);
    }
  for (std::int32_t y = 0; y + 1 < grid.n_rows; ++y)
    for (std::int32_t x = 0; x + 1 < grid.n_columns; ++x)
      EXPECT_EQ(level_of.contains({x, y}), delaunay::test::has_cell(grid, x, y));
}

TEST(restricted_quadtree, is_balanced_matching_and_within_its_tolerance) {
  for (const Case& c : cases()) {
    const SquareDomain domain = domain_of(c.grid);
    for (const double tolerance : kTolerances) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      Progress progress;
      const auto leaves = restricted_quadtree::build(domain, tolerance, progress);
      ASSERT_TRUE(leaves);
      expect_balanced(*leaves, c.grid);
      const Tin tin = to_tin(domain, *leaves);
      delaunay::test::expect_fills(tin, c.grid);
      EXPECT_LE(static_cast<double>(delaunay::test::largest_error(tin, c.grid)), tolerance);
      EXPECT_EQ(measure_gaps(tin).n_hanging, 0U);
      for (const auto& leaf : *leaves) EXPECT_LE(leaf.error, tolerance);
    }
  }
}

TEST(restricted_quadtree, adds_midpoints_for_accuracy_where_they_do) {
  // A ridge over a side of two quadrants, which the side's midpoint follows.
  const HeightGrid grid =
      make_grid<float>(9, 9, [](int x, int y) { return x <= 4 ? 0 : 4 - std::abs(y - 4) + 0 * x; });
  const SquareDomain domain = domain_of(grid);
  Progress progress;
  const auto leaves = restricted_quadtree::build(domain, 0.6, progress);
  ASSERT_TRUE(leaves);
  const bool has_midpoints = std::ranges::any_of(
      *leaves, [](const auto& leaf) { return leaf.square.level > 0 && leaf.midpoints != 0; });
  EXPECT_TRUE(has_midpoints);
  EXPECT_EQ(measure_gaps(to_tin(domain, *leaves)).n_hanging, 0U);
}

TEST(tin_gaps, are_found_and_closed) {
  for (const Case& c : cases()) {
    Progress progress;
    const auto tree = surface_quadtree::SurfaceQuadtree::build(c.grid, {2}, progress);
    ASSERT_TRUE(tree);
    for (const double tolerance : {150.0, 7.0}) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      Tin tin = to_tin(*tree, tree->leaves(tolerance));
      const TinGaps before = measure_gaps(tin);
      close_gaps(tin);
      const TinGaps after = measure_gaps(tin);
      EXPECT_EQ(after.n_hanging, before.n_hanging);
      EXPECT_LE(after.largest, 1e-9);
    }
  }
  // A triangle beside two that share its long side.
  Tin tin;
  tin.vertices = {{0, 0}, {2, 0}, {4, 0}, {2, 3}, {2, 5}};
  std::ranges::sort(tin.vertices, {}, [](delaunay::LatticePoint p) { return std::pair(p.y, p.x); });
  tin.heights = {0, 5, 2, 0, 0};
  tin.triangles = {{0, 2, 3}};
  EXPECT_EQ(measure_gaps(tin).n_hanging, 1U);
  EXPECT_EQ(measure_gaps(tin).largest, 4);
}

/// What the size theorem (section 4 of the survey) counts of a tree: its regions, the simple ones
/// (leaves), where it begins, and how many that are wholly beyond the domain its subdivisions lack.
struct TreeSize {
  std::size_t n_regions = 0;
  std::size_t n_simple = 0;
  std::size_t n_roots = 0;
  std::size_t n_lacking = 0;
  std::size_t n_lacking_one_or_more = 0;  ///< Subdivisions.
};

/// A region is a square, or half of one, by level, column, row and half.
using Region = std::array<std::int32_t, 4>;

/// From the leaves up; parent_of(region) is a region, or nothing of a root.
TreeSize size_of(const std::vector<Region>& leaves,
                 const std::function<std::optional<Region>(const Region&)>& parent_of) {
  std::map<Region, std::set<Region>> children;
  std::set<Region> roots;
  for (const Region& leaf : leaves) {
    Region at = leaf;
    while (const auto parent = parent_of(at)) {
      children[*parent].insert(at);
      at = *parent;
    }
    roots.insert(at);
  }
  TreeSize size{.n_simple = leaves.size(), .n_roots = roots.size()};
  for (const Region& leaf : leaves) EXPECT_FALSE(children.contains(leaf)) << "it is none";
  size.n_regions = leaves.size() + children.size();
  for (const auto& [parent, parts] : children) {
    EXPECT_LE(parts.size(), 4U);
    size.n_lacking += 4 - parts.size();
    size.n_lacking_one_or_more += parts.size() < 4 ? 1 : 0;
  }
  return size;
}

Region square_region(const Square& q) { return {q.level, q.column, q.row, 0}; }

std::optional<Region> square_above(const Region& region, std::int32_t n_levels) {
  if (region[0] + 1 == n_levels) return {};
  return Region{region[0] + 1, region[1] / 2, region[2] / 2, 0};
}

std::optional<Region> half_above(const Region& region, std::int32_t n_levels) {
  if (region[0] + 1 == n_levels) return {};
  const Square above{region[0] + 1, region[1] / 2, region[2] / 2};
  for (const bool is_upper : {false, true})
    for (int i = 0; i < 4; ++i) {
      const quaternary_triangulation::HalfSquare parent{above, is_upper};
      const auto child = parent.child(i);
      if (square_region(child.square) == Region{region[0], region[1], region[2], 0} &&
          child.is_upper == (region[3] == 1))
        return Region{above.level, above.column, above.row, is_upper ? 1 : 0};
    }
  ADD_FAILURE() << "a half without a parent";
  return {};
}

/// Each subdivision has four regions (b = 4), but for those beyond the domain, which are none. So
/// regions = (4 simple - roots + lacking) / 3: fewer than 4/3 of the simple ones where nothing is
/// lacking, or less than there are roots.
void expect_size(const TreeSize& size, const HeightGrid& grid) {
  EXPECT_EQ(3 * size.n_regions, 4 * size.n_simple - size.n_roots + size.n_lacking);
  if (size.n_lacking < size.n_roots) EXPECT_LT(3 * size.n_regions, 4 * size.n_simple);
  const bool is_whole = grid.n_missing() == 0;
  if (is_whole && grid.n_columns == 33 && grid.n_rows == 33) {
    EXPECT_EQ(size.n_lacking, 0U);
    EXPECT_LT(3 * size.n_regions, 4 * size.n_simple);
  }
  // Without gaps squares lack parts along the last column and row of each level alone.
  if (!is_whole) return;
  std::size_t n_rim = 0;
  for (int level = 1;
       (grid.n_columns - 2) >> (level - 1) > 0 || (grid.n_rows - 2) >> (level - 1) > 0; ++level)
    n_rim += 2 * static_cast<std::size_t>(((grid.n_columns - 2) >> level) +
                                          ((grid.n_rows - 2) >> level) + 1);
  EXPECT_LE(size.n_lacking_one_or_more, n_rim);
}

TEST(quadtrees, have_fewer_than_four_thirds_of_their_simple_regions_but_for_what_lies_beyond) {
  std::size_t n_above = 0;
  std::size_t n_below = 0;
  for (const Case& c : cases()) {
    Progress progress;
    const auto squares = surface_quadtree::SurfaceQuadtree::build(c.grid, {2}, progress);
    const auto halves =
        quaternary_triangulation::QuaternaryTriangulation::build(c.grid, {2}, progress);
    ASSERT_TRUE(squares && halves);
    const std::int32_t n_levels = squares->domain().n_levels();
    const auto above = [&](const Region& region) { return square_above(region, n_levels); };
    for (const double tolerance : kTolerances) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      std::vector<Region> leaves;
      for (const Square& leaf : squares->leaves(tolerance)) leaves.push_back(square_region(leaf));
      const TreeSize surface = size_of(leaves, above);
      expect_size(surface, c.grid);
      leaves.clear();
      const auto restricted = restricted_quadtree::build(squares->domain(), tolerance, progress);
      ASSERT_TRUE(restricted);
      for (const auto& leaf : *restricted) leaves.push_back(square_region(leaf.square));
      expect_size(size_of(leaves, above), c.grid);
      leaves.clear();
      for (const auto& leaf : halves->leaves(tolerance)) {
        leaves.push_back(square_region(leaf.square));
        leaves.back()[3] = leaf.is_upper ? 1 : 0;
      }
      const TreeSize quaternary =
          size_of(leaves, [&](const Region& region) { return half_above(region, n_levels); });
      expect_size(quaternary, c.grid);
      for (const TreeSize& size : {surface, quaternary})
        ++(3 * size.n_regions < 4 * size.n_simple ? n_below : n_above);
    }
  }
  // Both are met with: strips and gaps have subdivisions of one region or two.
  EXPECT_GT(n_above, 10U);
  EXPECT_GT(n_below, 10U);
}

TEST(quadtrees, refuse_rasters_without_a_cell) {
  Progress progress;
  for (const auto& [n_columns, n_rows] : {std::pair{1, 1}, {1, 9}, {9, 1}})
    EXPECT_FALSE(SquareDomain::make(make_grid<float>(n_columns, n_rows, hills)));
  HeightGrid missing = make_grid<float>(3, 3, hills);
  delaunay::test::set_missing(missing, 1, 1);
  EXPECT_FALSE(SquareDomain::make(missing));
  EXPECT_FALSE(surface_quadtree::SurfaceQuadtree::build(missing, {1}, progress));
}

}  // namespace
}  // namespace lode
