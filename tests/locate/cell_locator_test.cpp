// The locator of cells, against a look at all of them.

#include "lode/locate/cell_locator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode {
namespace {

using oracles::Random;

Vec3d point_near(Random& random) {
  Vec3d p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = random.uniform(-0.2, 1.2);
  return p;
}

/// Cells of all shapes and sizes, over each other.
TetraMesh heap_of_cells(std::uint64_t seed, std::size_t n) {
  Random random(seed);
  TetraMesh mesh;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3d middle = point_near(random);
    const double size = std::pow(10, random.uniform(-3, 0));
    const double height = i % 10 == 0 ? 0 : size * std::pow(10, random.uniform(-4, 0));
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int k = 0; k < 4; ++k)
      mesh.positions.push_back(middle +
                               Vec3d{{random.uniform(-size, size), random.uniform(-size, size),
                                      random.uniform(-height, height)}});
    mesh.tetrahedra.push_back({first, first + 1, first + 2, first + 3});
  }
  return mesh;
}

double least_by_volumes(const TetraMesh& mesh, std::size_t cell, const Vec3d& p) {
  const auto volume = [](const std::array<Vec3d, 4>& c) {
    return dot(cross(c[1] - c[0], c[2] - c[0]), c[3] - c[0]);
  };
  std::array<Vec3d, 4> corners;
  for (std::size_t k = 0; k < 4; ++k) corners[k] = mesh.positions[mesh.tetrahedra[cell][k]];
  const double whole = volume(corners);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 4; ++k) {
    auto part = corners;
    part[k] = p;
    least = std::min(least, volume(part) / whole);
  }
  return least;
}

TEST(cell_locator, finds_all_cells_that_hold_a_point) {
  for (const TetraMesh& mesh :
       {heap_of_cells(1, 900), oracles::noise_mesh(6, oracles::Cut::in_six, 3)}) {
    const CellLocator locator(mesh.positions, mesh.tetrahedra, {2});
    Random random(2);
    std::size_t n_held = 0;
    for (int trial = 0; trial < 400; ++trial) {
      const Vec3d p =
          trial % 3 == 0 ? mesh.positions[random.below(mesh.positions.size())] : point_near(random);
      std::set<std::uint32_t> near;
      locator.visit_near(p, 0, [&](std::uint32_t cell) { EXPECT_TRUE(near.insert(cell).second); });
      for (std::uint32_t cell = 0; cell < mesh.tetrahedra.size(); ++cell) {
        const CellWeights found = locator.weights_in(cell, p);
        if (std::isinf(found.rounding)) continue;
        EXPECT_NEAR(found.least(), least_by_volumes(mesh, cell, p),
                    8 * found.rounding * (1 + std::abs(found.least())));
        if (found.least() < 0) continue;
        ++n_held;
        EXPECT_TRUE(near.contains(cell));
      }
    }
    EXPECT_GT(n_held, 100U);
  }
}

TEST(cell_locator, knows_how_far_the_nearest_cell_is) {
  const TetraMesh mesh = heap_of_cells(5, 300);
  const CellLocator locator(mesh.positions, mesh.tetrahedra, {1});
  Random random(6);
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3d p = point_near(random) * 3;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t cell = 0; cell < mesh.tetrahedra.size(); ++cell)
      least = std::min(least, locator.distance_to_faces(cell, p));
    EXPECT_EQ(locator.distance_to_nearest(p), least);
  }
}

TEST(cell_locator, clamps_weights_to_the_cell_and_has_none_of_flat_cells) {
  const std::vector<Vec3d> positions{
      {{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{1, 1, 0}}};
  const std::vector<CellLocator::Cell> cells{{0, 1, 2, 3}, {0, 1, 2, 4}};
  const CellLocator locator(positions, cells, {1});
  const CellWeights outside = locator.weights_in(0, {{0.5, 0.5, -0.25}});
  EXPECT_EQ(outside.least(), -0.25);
  EXPECT_EQ(outside.clamped(), (std::array<double, 4>{0.2, 0.4, 0.4, 0}));
  EXPECT_TRUE(std::isinf(locator.weights_in(1, {{0.5, 0.5, 0}}).rounding));
  EXPECT_EQ(CellLocator({}, {}, {1}).distance_to_nearest({}),
            std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace lode
