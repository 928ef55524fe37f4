// Bisection of heights that are whole numbers of steps, and where errors of nodes are.
#include <cmath>
#include <set>

#include "tests/terrain/bisection_fixtures.h"

namespace lode {
namespace {

using bisection::Bisection;
using bisection::Diamond;
using bisection::Lattice;
using bisection::test::build;
using bisection::test::diamonds_of;
using bisection::test::hills;
using delaunay::LatticePoint;
using delaunay::test::make_grid;

TEST(bisection_steps, nodes_are_found_again_by_where_their_errors_are) {
  for (const auto& [n_columns, n_rows] :
       {std::pair{2, 2}, {601, 40}, {100, 100}, {64, 65}, {7, 300}, {513, 66}}) {
    const Lattice lattice(n_columns, n_rows);
    std::set<std::size_t> used;
    for (const Diamond& diamond : diamonds_of(lattice)) {
      const std::size_t i = lattice.index(diamond.node);
      ASSERT_LT(i, lattice.size());
      ASSERT_TRUE(used.insert(i).second);
      const auto stride = static_cast<std::size_t>(lattice.stride());
      ASSERT_EQ(lattice.node_at(static_cast<std::int32_t>(i % stride),
                                static_cast<std::int32_t>(i / stride)),
                diamond.node);
    }
  }
}

/// Which levels are is asked of nodes beyond the raster, too: one sample that is no tenth takes all
/// others to the other way of finding errors.
TEST(bisection_steps, level_parts_have_no_errors_whatever_the_steps) {
  for (const LatticePoint size : {LatticePoint{100, 100}, {601, 40}, {70, 64}}) {
    const auto tenths = [&](int x, int y) {
      return 2 * x > size.x || 2 * y > size.y ? 71.3 : std::round(7 * hills(x, y)) / 10;
    };
    HeightGrid grid = make_grid<double>(size.x, size.y, tenths);
    const Bisection made = build(grid);
    std::get<HeightGrid::Samples<double>>(grid.heights)[0] += 0.01234567;
    const Bisection expected = build(grid);
    const auto n_level = [&](const Bisection& bisection) {
      return std::ranges::count_if(diamonds_of(bisection.lattice()), [&](const Diamond& diamond) {
        return bisection.error(diamond.node) == 0;
      });
    };
    EXPECT_GT(n_level(expected), size.x * size.y / 2);
    EXPECT_EQ(n_level(made), n_level(expected));
  }
}

/// The same heights in other steps: where these have rounding of their own, it comes to the errors.
TEST(bisection_steps, errors_of_steps_are_those_of_their_numbers) {
  for (const auto& [n_columns, n_rows] : {std::pair{129, 129}, {64, 100}, {257, 40}}) {
    const auto numbers = [](int x, int y) { return x < 40 && y < 30 ? 90 : 5 * hills(x, y); };
    const Bisection expected = build(make_grid<std::int16_t>(n_columns, n_rows, numbers));
    for (const double per_unit : {1.0, 10.0, 100.0, 256.0}) {
      SCOPED_TRACE(per_unit);
      const HeightGrid grid = make_grid<double>(
          n_columns, n_rows, [&](int x, int y) { return (numbers(x, y) + 400) / per_unit; });
      // Of stretched diamonds errors are off by rounding of heights in float32.
      const bool is_stretched = n_columns != n_rows;
      const bool is_exact = !is_stretched && (per_unit == 1 || per_unit == 256);
      const double slack = is_exact ? 0 : is_stretched ? 0.004 / per_unit : 1e-9;
      const Bisection made = build(grid);
      EXPECT_EQ(made.error({12, 12}), 0);  // all is level round it
      for (const Diamond& diamond : diamonds_of(made.lattice())) {
        const double error = static_cast<double>(expected.error(diamond.node)) / per_unit;
        const auto found = static_cast<double>(made.error(diamond.node));
        ASSERT_GE(found, error);
        ASSERT_LE(found, error * (1 + (is_exact ? 0 : 0x1p-20)) + slack);
      }
    }
  }
}

}  // namespace
}  // namespace lode
