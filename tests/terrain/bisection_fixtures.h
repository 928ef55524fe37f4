#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "lode/models/terrain/right_triangle_bisection/bisection.h"
#include "tests/delaunay/lattice_fixtures.h"

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

}  // namespace lode::bisection::test
