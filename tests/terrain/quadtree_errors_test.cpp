// Errors of quadtrees against whole numbers: what they state is never too small, however high the
// heights and small their relief.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>

#include "lode/mappers/tin_quality.h"
#include "lode/models/terrain/quaternary_triangulation/quaternary_triangulation.h"
#include "lode/models/terrain/restricted_quadtree/pattern.h"
#include "lode/models/terrain/surface_quadtree/surface_quadtree.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/terrain/nodes_in_triangle.h"

namespace lode {
namespace {

using delaunay::LatticePoint;
using delaunay::Tin;
using delaunay::test::Int128;
using delaunay::test::make_grid;
using quaternary_triangulation::HalfSquare;
using quaternary_triangulation::QuaternaryTriangulation;
using squares::Square;
using squares::SquareDomain;
using surface_quadtree::SurfaceQuadtree;

/// All numbers here are whole ones in units of 2^-80.
constexpr int kUnitBits = 80;

/// Rounded down.
Int128 units_below(double value) {
  int exponent = 0;
  const double fraction = std::frexp(value, &exponent);
  const auto mantissa = static_cast<Int128>(std::ldexp(fraction, 53));
  const int shift = exponent - 53 + kUnitBits;
  return shift >= 0 ? mantissa * (static_cast<Int128>(1) << shift) : mantissa >> -shift;
}

Int128 units(double value) {
  const Int128 whole = units_below(value);
  EXPECT_EQ(whole, -units_below(-value)) << "finer than the unit";
  return whole;
}

Int128 distance(Int128 a, Int128 b) { return a < b ? b - a : a - b; }

/// An error as a fraction: times an area.
struct ExactError {
  Int128 scaled = 0;
  std::int64_t area = 1;

  [[nodiscard]] bool is_within(double bound) const { return scaled <= units_below(bound) * area; }
  [[nodiscard]] bool is(double value) const { return scaled == units(value) * area; }
  /// Some more than it is.
  [[nodiscard]] double above() const {
    return static_cast<double>(scaled / area + 1) * std::ldexp(1.0, -kUnitBits) * (1 + 0x1p-50);
  }
};

ExactError error_of_triangle(const HeightGrid& grid, LatticePoint a, LatticePoint b,
                             LatticePoint c) {
  ExactError worst{0, delaunay::doubled_area(a, b, c)};
  const auto z = [&](LatticePoint p) { return units(grid.height(p.x, p.y)); };
  test::for_each_node_in(
      a, b, c, [&](LatticePoint p, std::int64_t wa, std::int64_t wb, std::int64_t wc) {
        worst.scaled =
            std::max(worst.scaled, distance(z(p) * worst.area, wa * z(a) + wb * z(b) + wc * z(c)));
      });
  return worst;
}

ExactError error_of_square(const HeightGrid& grid, const Square& q) {
  const std::int64_t side = q.side();
  ExactError worst{0, side * side};
  const auto z = [&](std::int64_t u, std::int64_t v) {
    return units(
        grid.height(q.x() + static_cast<std::int32_t>(u), q.y() + static_cast<std::int32_t>(v)));
  };
  for (std::int64_t v = 0; v <= side; ++v)
    for (std::int64_t u = 0; u <= side; ++u)
      worst.scaled = std::max(
          worst.scaled, distance(z(u, v) * worst.area,
                                 (side - u) * (side - v) * z(0, 0) + u * (side - v) * z(side, 0) +
                                     (side - u) * v * z(0, side) + u * v * z(side, side)));
  return worst;
}

ExactError error_of_half(const HeightGrid& grid, const HalfSquare& half) {
  const LatticePoint a{half.square.x(), half.square.y()};
  const LatticePoint c{a.x + half.square.side(), a.y + half.square.side()};
  return half.is_upper ? error_of_triangle(grid, a, c, {a.x, c.y})
                       : error_of_triangle(grid, a, {c.x, a.y}, c);
}

ExactError error_of_pattern(const HeightGrid& grid, const Square& q,
                            restricted_quadtree::SideMask midpoints) {
  // Their areas are halves or quarters of side².
  ExactError worst{0, std::int64_t{q.side()} * q.side()};
  restricted_quadtree::visit_pattern(
      q, midpoints, [&](LatticePoint a, LatticePoint b, LatticePoint c) {
        const ExactError own = error_of_triangle(grid, a, b, c);
        worst.scaled = std::max(worst.scaled, own.scaled * (worst.area / own.area));
      });
  return worst;
}

double relief(std::int32_t x, std::int32_t y) {
  return std::round(300 * std::sin(0.3 * x) * std::cos(0.2 * y)) / 100;
}

struct HighCase {
  const char* name;
  HeightGrid grid;
  bool is_exact = true;  ///< Whether float64 has all that errors are made of.
};

std::vector<HighCase> high_cases() {
  std::vector<HighCase> all;
  const auto add = [&](const char* name, const std::function<double(int, int)>& rule) {
    all.push_back({name, make_grid<double>(57, 40, rule)});
  };
  add("centimetres at 1e9", [](int x, int y) { return 1e9 + relief(x, y); });
  add("below -1e9", [](int x, int y) { return relief(x, y) - 1e9; });
  add("on both sides of a power of two", [](int x, int y) { return 0x1p30 + relief(x, y); });
  add("tenths of millimetres at 4e8", [](int x, int y) { return 4e8 + relief(x, y) / 100; });
  add("a lake beside nothing", [](int x, int y) { return 1e9 + std::max(0.0, relief(x, y)); });
  delaunay::test::set_missing(all.back().grid, 30, 30);
  // Whose differences are not what float64 makes of them.
  add("of all sizes",
      [](int x, int y) { return std::ldexp(std::sin(0.7 * x + y) + 1.5, y % 5 * 7 - 20); });
  all.back().is_exact = false;
  add("of 53 bits", [](int x, int y) { return 1e9 * std::sin(0.31 * x + 0.2 * y) / 3; });
  all.back().is_exact = false;
  // Of so many bits that only small squares are exact.
  add("of 45 bits", [](int x, int y) {
    return std::round(0x1p45 * std::sin(0.03 * x) * std::cos(0.02 * y)) * 0x1p-40;
  });
  all.back().is_exact = false;
  return all;
}

constexpr std::array kFineTolerances{1.0, 0.1, 0.02, 0.003, 0.0};

/// It is true, and no more than rounding too large: 2^-47 of the range, or, of floats, 2^-23 of it.
void expect_bound(const ExactError& error, double stated, const HighCase& c, bool is_float) {
  EXPECT_TRUE(error.is_within(stated)) << stated;
  const HeightRange range = height_range(c.grid);
  const double slack = c.is_exact ? 0 : 0x1p-47 * (range.upper - range.lower);
  EXPECT_LE(stated, error.above() * (is_float ? 1 + 0x1p-23 : 1) + slack);
  if (c.is_exact && !is_float) EXPECT_TRUE(error.is(stated)) << stated;
}

TEST(quadtree_errors, are_bounds_of_whole_numbers_errors) {
  for (const HighCase& c : high_cases()) {
    SCOPED_TRACE(c.name);
    Progress progress;
    const auto surface = SurfaceQuadtree::build(c.grid, {2}, progress);
    const auto halves = QuaternaryTriangulation::build(c.grid, {2}, progress);
    ASSERT_TRUE(surface && halves);
    const SquareDomain& domain = surface->domain();
    std::size_t n = 0;
    for (std::int32_t level = 1; level < domain.n_levels(); ++level)
      for (std::int32_t row = 0; row < domain.n_rows(level); ++row)
        for (std::int32_t column = 0; column < domain.n_columns(level); ++column) {
          const Square q{level, column, row};
          for (const bool is_upper : {false, true}) {
            const HalfSquare half{q, is_upper};
            if (std::isinf(halves->error(half))) continue;
            ++n;
            expect_bound(error_of_half(c.grid, half), static_cast<double>(halves->error(half)), c,
                         true);
            expect_bound(error_of_half(c.grid, half), linear_error(domain, half), c, false);
          }
          if (domain.share(q) != squares::Share::all) continue;
          expect_bound(error_of_square(c.grid, q), static_cast<double>(surface->error(q)), c, true);
          expect_bound(error_of_square(c.grid, q), surface_quadtree::bilinear_error(domain, q), c,
                       false);
          for (const restricted_quadtree::SideMask mask :
               std::array<restricted_quadtree::SideMask, 6>{0, 1, 3, 5, 7, 15})
            expect_bound(error_of_pattern(c.grid, q, mask),
                         restricted_quadtree::pattern_error(domain, q, mask), c, false);
        }
    EXPECT_GT(n, 1000U);
  }
}

bool keeps(const Tin& tin, const HeightGrid& grid, double tolerance) {
  return std::ranges::all_of(tin.triangles, [&](const auto& t) {
    return error_of_triangle(grid, tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]])
        .is_within(tolerance);
  });
}

TEST(quadtree_errors, leave_meshes_within_their_tolerance_and_states_and_measures_true) {
  for (const HighCase& c : high_cases())
    for (const double tolerance : kFineTolerances) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      Progress progress;
      const auto halves = QuaternaryTriangulation::build(c.grid, {2}, progress);
      ASSERT_TRUE(halves);
      const auto leaves = restricted_quadtree::build(halves->domain(), tolerance, progress);
      ASSERT_TRUE(leaves);
      for (const Tin& tin : {to_tin(*halves, halves->leaves(tolerance)),
                             restricted_quadtree::to_tin(halves->domain(), *leaves)}) {
        EXPECT_TRUE(keeps(tin, c.grid, tolerance));
        // What is measured of a mesh is true, too, whoever made it, and no more than rounded up.
        const double measured = measure_quality(tin, 1, c.grid, {2}).worst_error;
        EXPECT_TRUE(keeps(tin, c.grid, measured)) << measured;
        if (measured > 0) EXPECT_FALSE(keeps(tin, c.grid, std::nextafter(measured, 0))) << measured;
      }
    }
}

/// Of a power of two and one columns and rows.
struct LeafCounts {
  std::size_t squares = 0;
  std::size_t halves = 0;
  std::size_t patterns = 0;

  friend bool operator==(const LeafCounts&, const LeafCounts&) = default;
};

LeafCounts count_leaves(const HeightGrid& grid, double tolerance) {
  Progress progress;
  const auto surface = SurfaceQuadtree::build(grid, {1}, progress);
  const auto halves = QuaternaryTriangulation::build(grid, {1}, progress);
  EXPECT_TRUE(surface && halves);
  const auto patterns = restricted_quadtree::build(surface->domain(), tolerance, progress);
  EXPECT_TRUE(patterns);
  return {surface->leaves(tolerance).size(), halves->leaves(tolerance).size(), patterns->size()};
}

TEST(quadtree_errors, are_none_of_planes_that_floats_have) {
  // A restricted quadtree begins with four quadrants.
  const LeafCounts least{1, 2, 4};
  const auto level = [](double z) {
    return make_grid<double>(65, 65, [z](int, int) { return z; });
  };
  for (const double z : {0.0, 0.1, 1e9 + 0.37, -1e30, 5e-324})
    EXPECT_EQ(count_leaves(level(z), 0), least);
  EXPECT_EQ(
      count_leaves(make_grid<std::int16_t>(65, 65, [](int x, int y) { return 7 * x - 3 * y; }), 0),
      least);
  EXPECT_EQ(
      count_leaves(make_grid<double>(65, 65, [](int x, int y) { return 1e9 + 0.25 * x - 0.5 * y; }),
                   0),
      least);
  // Level but for some cells far away, whose heights have all bits.
  HeightGrid steep = make_grid<double>(
      129, 65, [](int x, int y) { return x <= 64 ? 0.1 : 1e9 * std::sin(x + 0.1 * y); });
  Progress progress;
  const auto surface = SurfaceQuadtree::build(steep, {1}, progress);
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->error({6, 0, 0}), 0);
}

TEST(quadtree_errors, that_equal_a_whole_tolerance_are_within_it) {
  // A spike where no pattern of any of the four quadrants has a vertex.
  const auto spike = [](double base) {
    return make_grid<double>(17, 17,
                             [base](int x, int y) { return base + (x == 3 && y == 2 ? 5 : 0); });
  };
  for (const double base : {0.0, 1e9}) {
    EXPECT_EQ(count_leaves(spike(base), 5), (LeafCounts{1, 2, 4}));
    const LeafCounts finer = count_leaves(spike(base), std::nextafter(5.0, 0));
    EXPECT_GT(finer.squares, 1U);
    EXPECT_GT(finer.halves, 2U);
    EXPECT_GT(finer.patterns, 4U);
  }
}

}  // namespace
}  // namespace lode
