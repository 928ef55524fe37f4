#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lode/models/terrain/right_triangle_bisection/bisection.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/random.h"

namespace lode::bisection::test {

constexpr auto hills = delaunay::test::spiky_hills;

inline Bisection build(const HeightGrid& grid, int n_threads = 2) {
  Progress progress;
  auto made = Bisection::build(grid, {n_threads}, progress);
  EXPECT_TRUE(made) << made.error().message;
  return *std::move(made);
}

/// All nodes whose diamonds have some area.
inline std::vector<Diamond> diamonds_of(const Lattice& lattice) {
  std::vector<Diamond> all;
  for (std::int32_t y = 0; y <= lattice.side(); ++y)
    for (std::int32_t x = 0; x <= lattice.side(); ++x) {
      if (lattice.is_corner({x, y})) continue;
      const Diamond diamond({x, y});
      if (lattice.has_area(diamond.node, diamond.reach)) all.push_back(diamond);
    }
  return all;
}

/// Of any size from a cell to a few strips, with noise of any kind, and often with holes.
inline HeightGrid random_grid(oracles::Random& random) {
  const auto side = [&] {
    const std::int32_t around = 1 << random.below(9);
    return std::max<std::int32_t>(2, around + static_cast<std::int32_t>(random.below(5)) - 1);
  };
  std::int32_t n_columns = side();
  const std::int32_t n_rows = side();
  if (random.below(3) == 0) n_columns = 2 + static_cast<std::int32_t>(random.below(90));
  const double rough = std::exp2(random.uniform(-10, 14));
  const double offset = random.below(4) == 0 ? 1e9 : 0;
  const auto noise = [&](int x, int y) {
    return rough * (std::sin(0.05 * x) + std::cos(0.07 * y) + 0.2 * random.uniform());
  };
  HeightGrid grid;
  switch (random.below(4)) {
    case 0:
      grid = delaunay::test::make_grid<std::int16_t>(n_columns, n_rows, [&](int x, int y) {
        return std::clamp(noise(x, y), -32768.0, 32767.0);
      });
      break;
    case 1:
      grid = delaunay::test::make_grid<std::uint16_t>(
          n_columns, n_rows, [&](int, int) { return static_cast<double>(random.below(65536)); });
      break;
    case 2: grid = delaunay::test::make_grid<float>(n_columns, n_rows, noise); break;
    default:
      grid = delaunay::test::make_grid<double>(n_columns, n_rows,
                                               [&](int x, int y) { return offset + noise(x, y); });
  }
  if (random.below(2) == 0)
    for (std::uint64_t i = random.below(1 + static_cast<std::uint64_t>(grid.n_samples()) / 4);
         i > 0; i /= 2)
      delaunay::test::set_missing(
          grid, static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(n_columns))),
          static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(n_rows))));
  return grid;
}

}  // namespace lode::bisection::test
