// Where points and lines are among cells, decided exactly.

#include "lode/locate/point_location.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lode/locate/line_profile.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode {
namespace {

using oracles::Random;

/// A cube in cells, some of them slivers: inner vertices are at odd places of a thin layer.
TetraMesh cube_with_slivers(double thickness) {
  TetraMesh mesh = oracles::noise_mesh(5, oracles::Cut::in_six, 4);
  Random random(8);
  for (Vec3d& p : mesh.positions) {
    const bool is_inner = std::ranges::all_of(p.v, [](double x) { return x > 0 && x < 1; });
    p[2] *= thickness;
    if (!is_inner) continue;
    for (std::size_t i = 0; i < 2; ++i) p[i] += random.uniform(-0.02, 0.02);
  }
  return mesh;
}

TEST(point_location, loses_no_point_between_cells_however_thin) {
  for (const double thickness : {1.0, 1e-4, 1e-9}) {
    const TetraMesh mesh = cube_with_slivers(thickness);
    const CellLocator locator(mesh.positions, mesh.tetrahedra, {2});
    Random random(3);
    for (int trial = 0; trial < 3000; ++trial) {
      const auto& t = mesh.tetrahedra[random.below(mesh.tetrahedra.size())];
      const Vec3d& a = mesh.positions[t[0]];
      const Vec3d& b = mesh.positions[t[1]];
      // Vertices, as near to edges as doubles come, and anywhere.
      Vec3d p = trial % 3 == 0 ? a : a + (b - a) * random.uniform(0, 1);
      if (trial % 3 == 2)
        p = {{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, thickness)}};
      for (std::size_t i = 0; i < 3; ++i) p[i] = std::clamp(p[i], 0.0, i == 2 ? thickness : 1.0);
      const auto cell = find_cell(locator, p, {});
      ASSERT_TRUE(cell) << trial;
      EXPECT_TRUE(holds(locator, *cell, p));
      std::array<double, 4> heights{};
      for (std::size_t k = 0; k < 4; ++k) heights[k] = mesh.positions[mesh.tetrahedra[*cell][k]][2];
      const RoundedValue height = value_in(locator, *cell, p, heights);
      EXPECT_LE(height.low, p[2]);
      EXPECT_GE(height.high, p[2]);
    }
    EXPECT_FALSE(find_cell(locator, {{0.5, 0.5, -1e-300}}, {}));
    EXPECT_FALSE(find_cell(locator, {{std::nextafter(1.0, 2.0), 0.5, 0}}, {}));
  }
}

TEST(point_location, prefers_what_is_preferred_and_leaves_out_flat_cells) {
  const std::vector<Vec3d> positions{{{0, 0, 0}}, {{1, 0, 0}},  {{0, 1, 0}},
                                     {{0, 0, 1}}, {{0, 0, -1}}, {{1, 1, 0}}};
  // Above and below a face, the latter turned round, and flat in it.
  const std::vector<CellLocator::Cell> cells{{0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 2, 5}};
  const CellLocator locator(positions, cells, {1});
  const Vec3d p{{0.25, 0.25, 0}};
  EXPECT_TRUE(holds(locator, 0, p));
  EXPECT_TRUE(holds(locator, 1, p));
  EXPECT_FALSE(holds(locator, 2, p));
  EXPECT_EQ(find_cell(locator, p, {}), 0U);
  EXPECT_EQ(find_cell(locator, p, std::vector<std::uint8_t>{0, 1, 1}), 1U);
  const RoundedValue flat = value_in(locator, 2, p, {4, 5, 6, 7});
  EXPECT_EQ(flat.low, 4);
  EXPECT_EQ(flat.high, 7);
}

TEST(line_profile, goes_from_face_to_face_without_a_gap) {
  for (const double thickness : {1.0, 1e-4}) {
    const TetraMesh mesh = cube_with_slivers(thickness);
    const CellLocator locator(mesh.positions, mesh.tetrahedra, {2});
    Random random(5);
    for (int trial = 0; trial < 300; ++trial) {
      Vec3d a{{random.uniform(0, 1), random.uniform(0, 1), 0}};
      Vec3d b{{random.uniform(0, 1), random.uniform(0, 1), thickness}};
      // From vertex to vertex: along edges, through others, in the boundary.
      if (trial % 2 == 0) a = mesh.positions[random.below(mesh.positions.size())];
      if (trial % 2 == 0) b = mesh.positions[random.below(mesh.positions.size())];
      if (a == b) continue;
      const auto profile = line_profile(locator, a, b, {});
      ASSERT_FALSE(profile.empty());
      EXPECT_TRUE(profile.front().starts_part);
      EXPECT_NEAR(profile.front().begin, 0, 1e-9);
      EXPECT_NEAR(profile.back().end, 1, 1e-9);
      for (std::size_t i = 1; i < profile.size(); ++i) {
        EXPECT_FALSE(profile[i].starts_part) << trial;
        EXPECT_EQ(profile[i].begin, profile[i - 1].end);
        EXPECT_LT(profile[i].begin, profile[i].end);
      }
      // Each piece is in its cell, but for rounding.
      for (const LinePiece& piece : profile) {
        const Vec3d p = a + (b - a) * ((piece.begin + piece.end) / 2);
        const CellWeights found = locator.weights_in(piece.cell, p);
        EXPECT_GE(found.least(), -1e-6 - found.rounding);
      }
    }
  }
}

TEST(line_profile, tells_parts_apart_and_is_empty_outside) {
  const std::vector<Vec3d> positions{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}},
                                     {{3, 0, 0}}, {{4, 0, 0}}, {{3, 1, 0}}, {{3, 0, 1}}};
  const std::vector<CellLocator::Cell> cells{{0, 1, 2, 3}, {4, 5, 6, 7}};
  const CellLocator locator(positions, cells, {1});
  const auto profile = line_profile(locator, {{-1, 0.25, 0.25}}, {{7, 0.25, 0.25}}, {});
  ASSERT_EQ(profile.size(), 2U);
  EXPECT_TRUE(profile[1].starts_part);
  EXPECT_EQ(profile[0].begin, 0.125);
  EXPECT_EQ(profile[0].end, 0.1875);
  EXPECT_EQ(profile[1].begin, 0.5);
  EXPECT_EQ(profile[1].end, 0.5625);
  EXPECT_TRUE(line_profile(locator, {{-1, 2, 0.25}}, {{7, 2, 0.25}}, {}).empty());
  // A corner alone is no part.
  EXPECT_TRUE(line_profile(locator, {{-1, 0, 1}}, {{1, 0, 1}}, {}).empty());
  EXPECT_TRUE(meets_line({{{0, 0, 0}}, {{1, 1, 1}}}, {{-1, -1, -1}}, {{0, 0, 0}}));
  EXPECT_FALSE(meets_line({{{0, 0, 0}}, {{1, 1, 1}}}, {{-1, 2, 0}}, {{2, 2, 0}}));
}

}  // namespace
}  // namespace lode
