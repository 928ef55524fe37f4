// The size theorem of the survey (section 4) for bisection: all triangles that there are against
// those of full resolution.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <set>

#include "lode/models/terrain/right_triangle_bisection/extract.h"
#include "tests/terrain/bisection_fixtures.h"

namespace lode::bisection {
namespace {

using delaunay::LatticePoint;
using PlacedTriangle = std::array<std::pair<std::int32_t, std::int32_t>, 3>;

/// All triangles of the hierarchy, from its definition: halves of a square of 2^k columns and rows,
/// bisected from the middle of their longest side to the corner across down to halves of cells; of
/// what lies beyond the raster the last column and row stand, and triangles without area are none.
struct AllTriangles {
  LatticePoint last;
  std::size_t n_regions = 0;
  std::size_t n_roots = 0;
  std::size_t n_lacking = 0;               ///< Halves that are none.
  std::set<PlacedTriangle> all{};          ///< Where they are.
  std::multiset<PlacedTriangle> simple{};  ///< Not bisected.

  explicit AllTriangles(const HeightGrid& grid) : last{grid.n_columns - 1, grid.n_rows - 1} {
    std::int32_t side = 1;
    while (side < std::max(last.x, last.y)) side *= 2;
    for (const auto& corners : {std::array<LatticePoint, 3>{{{side, side}, {0, 0}, {side, 0}}},
                                {{{0, 0}, {side, side}, {0, side}}}}) {
      if (!has_area(corners)) continue;
      ++n_roots;
      add(corners);
    }
  }

 private:
  [[nodiscard]] LatticePoint place(LatticePoint p) const {
    return {std::min(p.x, last.x), std::min(p.y, last.y)};
  }
  [[nodiscard]] bool has_area(const std::array<LatticePoint, 3>& t) const {
    return delaunay::doubled_area(place(t[0]), place(t[1]), place(t[2])) > 0;
  }
  /// The longest side is from corner 0 to corner 1.
  void add(const std::array<LatticePoint, 3>& t) {
    ++n_regions;
    PlacedTriangle placed;
    for (std::size_t i = 0; i < 3; ++i) placed[i] = {place(t[i]).x, place(t[i]).y};
    std::ranges::rotate(placed, std::ranges::min_element(placed));
    all.insert(placed);
    if (std::abs(t[0].x - t[1].x) <= 1 && std::abs(t[0].y - t[1].y) <= 1) {
      simple.insert(placed);
      return;
    }
    const LatticePoint middle{(t[0].x + t[1].x) / 2, (t[0].y + t[1].y) / 2};
    for (const auto& half : {std::array<LatticePoint, 3>{{t[2], t[0], middle}},
                             std::array<LatticePoint, 3>{{t[1], t[2], middle}}})
      has_area(half) ? add(half) : static_cast<void>(++n_lacking);
  }
};

std::multiset<PlacedTriangle> placed_in(const delaunay::Tin& tin) {
  std::multiset<PlacedTriangle> found;
  for (const auto& t : tin.triangles) {
    PlacedTriangle placed;
    for (std::size_t i = 0; i < 3; ++i) placed[i] = {tin.vertices[t[i]].x, tin.vertices[t[i]].y};
    std::ranges::rotate(placed, std::ranges::min_element(placed));
    found.insert(placed);
  }
  return found;
}

TEST(right_triangle_bisection, has_fewer_than_twice_the_triangles_of_full_resolution) {
  oracles::Random random(9);
  for (const auto& [n_columns, n_rows] :
       {std::pair{17, 17}, {33, 33}, {2, 2}, {20, 33}, {31, 18}, {2, 40}, {41, 3}}) {
    SCOPED_TRACE(testing::Message() << n_columns << " x " << n_rows);
    // Noise: full resolution has all samples.
    const HeightGrid grid = delaunay::test::make_grid<float>(
        n_columns, n_rows, [&](int, int) { return random.uniform(-100, 100); });
    const AllTriangles expected(grid);
    const Bisection tree = test::build(grid);
    const auto full = placed_in(tin_within(tree, grid, 0));
    EXPECT_EQ(full.size(), 2U * static_cast<unsigned>((n_columns - 1) * (n_rows - 1)));
    // A mesh of any tolerance has no others.
    for (const double tolerance : {150.0, 90.0, 60.0, 30.0, 5.0, 0.0})
      for (const PlacedTriangle& one : placed_in(tin_within(tree, grid, tolerance)))
        EXPECT_TRUE(expected.all.contains(one));
    // Each bisection has two parts, b = 2, but for those beyond the raster: regions are
    // 2 simple - roots + lacking.
    EXPECT_EQ(expected.n_regions,
              2 * expected.simple.size() - expected.n_roots + expected.n_lacking);
    const bool is_power = n_columns == n_rows;
    EXPECT_EQ(expected.n_lacking == 0, is_power);
    if (!is_power) continue;
    EXPECT_EQ(full, expected.simple);
    EXPECT_LT(expected.n_regions, 2 * full.size());
  }
}

}  // namespace
}  // namespace lode::bisection
