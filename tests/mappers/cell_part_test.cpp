// Parts of tetrahedra in boxes: volumes and integrals that add up.

#include "lode/mappers/cell_part.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/oracles/random.h"

namespace lode {
namespace {

using oracles::Random;

double at(const Vec3d& p) { return 3 + 2 * p[0] - p[1] + 0.25 * p[2]; }

std::array<double, 4> values_at(const std::array<Vec3d, 4>& corners) {
  return {at(corners[0]), at(corners[1]), at(corners[2]), at(corners[3])};
}

TEST(cell_part, is_the_box_where_that_is_inside) {
  const std::array<Vec3d, 4> corners{
      {{{-9, -9, -9}}, {{30, -9, -9}}, {{-9, 30, -9}}, {{-9, -9, 30}}}};
  const Box3d box{{{0, 1, 2}}, {{0.5, 1.75, 2.125}}};
  const CellPart part = part_in_box(corners, values_at(corners), box);
  const double volume = 0.5 * 0.75 * 0.125;
  EXPECT_FALSE(part.is_whole);
  EXPECT_NEAR(part.volume, volume, 1e-15);
  EXPECT_NEAR(part.integral, volume * at((box.lower + box.upper) * 0.5), 1e-14);
  EXPECT_NEAR(part.lowest, at({{0, 1.75, 2}}), 1e-13);
  EXPECT_NEAR(part.highest, at({{0.5, 1, 2.125}}), 1e-13);
}

TEST(cell_part, knows_what_is_whole_and_what_is_outside) {
  const std::array<Vec3d, 4> corners{{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}}};
  const std::array<double, 4> values{1, 2, 3, 4};
  for (const auto& box : {std::optional<Box3d>{}, {Box3d{{{0, 0, 0}}, {{1, 1, 1}}}}}) {
    const CellPart whole = part_in_box(corners, values, box);
    EXPECT_TRUE(whole.is_whole);
    EXPECT_DOUBLE_EQ(whole.volume, 1.0 / 6);
    EXPECT_DOUBLE_EQ(whole.integral, 2.5 / 6);
    EXPECT_EQ(whole.lowest, 1);
    EXPECT_EQ(whole.highest, 4);
  }
  const CellPart none = part_in_box(corners, values, Box3d{{{2, 0, 0}}, {{3, 1, 1}}});
  EXPECT_TRUE(none.is_empty());
  EXPECT_EQ(none.volume, 0);
  EXPECT_EQ(none.volume_rounding, 0);
  // In the box's corner, but not in the box's inside.
  EXPECT_EQ(part_in_box(corners, values, Box3d{{{0.9, 0.9, 0.9}}, {{2, 2, 2}}}).volume, 0);
  // Half of it, at a vertex's plane; and what is turned round is as large.
  const std::array<Vec3d, 4> turned{corners[1], corners[0], corners[2], corners[3]};
  EXPECT_DOUBLE_EQ(part_in_box(turned, values, std::nullopt).volume, 1.0 / 6);
}

TEST(cell_part, adds_up_over_boxes_within_the_rounding_it_states) {
  Random random(7);
  for (int trial = 0; trial < 2000; ++trial) {
    // Of all sizes, near and far, some of them slivers.
    const double size = std::pow(10, random.uniform(-3, 3));
    const double far = trial % 3 == 0 ? 1e4 * size : 0;
    const double height = trial % 4 == 0 ? 1e-7 : 1;
    std::array<Vec3d, 4> corners;
    for (Vec3d& p : corners)
      p = {{far + random.uniform(-size, size), random.uniform(-size, size),
            far + height * random.uniform(-size, size)}};
    const std::array<double, 4> values = values_at(corners);
    std::array<std::array<double, 4>, 3> planes;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d& p = corners[static_cast<std::size_t>(trial) % 4];
      // Some through a corner.
      planes[i] = {-1e9, (i == 0 ? p[i] : corners[0][i] / 2 + corners[1][i] / 2), 0, 1e9};
      planes[i][2] = planes[i][1] + random.uniform(0, size / 2);
    }
    const CellPart whole = part_in_box(corners, values, std::nullopt);
    CellPart sum;
    for (std::size_t n = 0; n < 27; ++n) {
      const std::array<std::size_t, 3> at_plane{n % 3, n / 3 % 3, n / 9};
      Box3d box;
      for (std::size_t i = 0; i < 3; ++i) {
        box.lower[i] = planes[i][at_plane[i]];
        box.upper[i] = planes[i][at_plane[i] + 1];
      }
      const CellPart part = part_in_box(corners, values, box);
      sum.volume += part.volume;
      sum.integral += part.integral;
      sum.volume_rounding += part.volume_rounding;
      sum.integral_rounding += part.integral_rounding;
      if (part.is_empty()) continue;
      EXPECT_GE(part.lowest, std::ranges::min(values));
      EXPECT_LE(part.highest, std::ranges::max(values));
    }
    EXPECT_NEAR(sum.volume, whole.volume, sum.volume_rounding + whole.volume_rounding) << trial;
    EXPECT_NEAR(sum.integral, whole.integral, sum.integral_rounding + whole.integral_rounding);
    // Cells are up to 2 sizes wide, so that each piece may be off by 4096 units; the 27 boxes cut
    // them in up to some 800 together.
    EXPECT_LT(sum.volume_rounding, 1000 * 4096 * 0x1p-53 * size * size * size);
  }
}

}  // namespace
}  // namespace lode
