#include <cmath>

#include "lode/models/terrain/right_triangle_bisection/extract.h"
#include "tests/models/all_targets.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/terrain/bisection_fixtures.h"

namespace lode::bisection {
namespace {

using delaunay::Tin;

/// Which small rasters get from a scan of all errors, and others from a walk alone.
void expect_same_as_of_nodes(const Bisection& made, const HeightGrid& grid, double tolerance) {
  NodeSet refined(made.lattice());
  for (const Diamond& diamond : test::diamonds_of(made.lattice()))
    if (made.error(diamond.node) > static_cast<float>(tolerance))
      refined.add(static_cast<std::int64_t>(made.lattice().index(diamond.node)));
  const Tin expected = tin_of(made, grid, refined);
  for (const int n_threads : {1, 2, 5}) {
    const Tin tin = tin_within(made, grid, tolerance, {n_threads});
    EXPECT_TRUE(tin.vertices == expected.vertices);
    EXPECT_TRUE(tin.triangles == expected.triangles);
    EXPECT_TRUE(tin.errors == expected.errors);
    EXPECT_TRUE(tin.heights == expected.heights);
  }
}

TEST(scanned_mesh, is_that_of_the_nodes_above_the_tolerance) {
  oracles::Random random(26);
  for (int trial = 0; trial < oracles::trials(1000, 60); ++trial) {
    const HeightGrid grid = test::random_grid(random);
    SCOPED_TRACE(testing::Message()
                 << "trial " << trial << ": " << grid.n_columns << " x " << grid.n_rows);
    Progress progress;
    auto made = Bisection::build(grid, {1}, progress);
    if (!made) continue;
    const HeightRange range = height_range(grid);
    const double wide = (range.upper - range.lower) * std::exp2(random.uniform(-12, 0));
    for (const double tolerance : {0.0, static_cast<double>(static_cast<float>(wide)), 1e30})
      expect_same_as_of_nodes(*made, grid, tolerance);
    if (!made->is_whole()) continue;
    made->keep({{grid.n_columns - 1, 0}, {grid.n_columns / 2, grid.n_rows / 2}});
    expect_same_as_of_nodes(*made, grid, static_cast<double>(static_cast<float>(wide)));
  }
  // So many triangles that threads share them, and rows of words.
  const auto noise = [&](int, int) { return static_cast<double>(random.below(1000)); };
  for (const LatticePoint size : oracles::trials<std::vector<LatticePoint>>(
           {{731, 700}, {300, 900}, {1100, 900}}, {{300, 700}})) {
    const HeightGrid grid = delaunay::test::make_grid<std::int16_t>(size.x, size.y, noise);
    const Bisection made = test::build(grid);
    for (const double tolerance : {0.0, 300.0})
      lode::test::for_each_target([&] { expect_same_as_of_nodes(made, grid, tolerance); });
  }
}

}  // namespace
}  // namespace lode::bisection
