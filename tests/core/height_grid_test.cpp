#include "lode/core/height_grid.h"

#include <gtest/gtest.h>

#include "tests/oracles/random.h"

namespace lode {
namespace {

TEST(height_grid, finds_the_columns_and_rows_of_its_samples_exactly) {
  oracles::Random random(3);
  HeightGrid grid = make_height_grid<float>(3, 3);
  for (int i = 0; i < 300; ++i) {
    const double step = random.uniform(1e-5, 100);
    const double turn = i % 3 == 0 ? random.uniform(-1, 1) * step : 0;
    grid.to_world = {random.uniform(-1e7, 1e7), step,  turn,
                     random.uniform(-1e7, 1e7), -turn, i % 2 == 0 ? -step : 1.25 * step};
    for (int k = 0; k < 30; ++k) {
      const auto x = static_cast<double>(random.below(40000));
      const auto y = static_cast<double>(random.below(40000));
      const Vec<double, 2> world = grid.world(x, y);
      EXPECT_EQ(grid.snapped_lattice(world[0], world[1]), (Vec<double, 2>{{x, y}}));
    }
  }
}

TEST(height_grid, moves_no_place_that_is_beside_a_column) {
  HeightGrid grid = make_height_grid<float>(3, 3);
  grid.to_world = {500000, 30, 0, 4000000, 0, -30};
  const Vec<double, 2> at = grid.snapped_lattice(500030.0001, 3999970);
  EXPECT_GT(at[0], 1);
  EXPECT_EQ(at[1], 1);
}

}  // namespace
}  // namespace lode
