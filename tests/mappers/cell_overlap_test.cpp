// What two tetrahedra have in common, and a function on it.

#include "lode/mappers/cell_overlap.h"

#include <gtest/gtest.h>

#include "lode/core/vec.h"

namespace lode {
namespace {

/// Of points of the unit tetrahedron's space, with x for the difference.
OverlapCorner seen(double x, double y, double z) { return {{1 - x - y - z, x, y, z}, x}; }

double largest(const std::array<OverlapCorner, 4>& cell) {
  const auto overlap = find_overlap(cell);
  return overlap ? overlap->largest : -1;
}

TEST(cell_overlap, of_a_cell_in_another_is_its_own_corners) {
  EXPECT_DOUBLE_EQ(
      largest({seen(0.1, 0.1, 0.1), seen(0.4, 0.1, 0.1), seen(0.1, 0.4, 0.1), seen(0.1, 0.1, 0.4)}),
      0.4);
}

TEST(cell_overlap, of_a_cell_round_another_is_the_others_corners) {
  EXPECT_DOUBLE_EQ(
      largest({seen(-9, -9, -9), seen(40, -9, -9), seen(-9, 40, -9), seen(-9, -9, 40)}), 1);
}

TEST(cell_overlap, is_where_edges_cross_faces) {
  // An edge along x at y = z = 0.25 leaves at x = 0.5, and enters at 0.
  EXPECT_NEAR(largest({seen(-1, 0.25, 0.25), seen(2, 0.25, 0.25), seen(-1, 0.2500001, 0.25),
                       seen(-1, 0.25, 0.2500001)}),
              0.5, 1e-6);
}

TEST(cell_overlap, is_nothing_where_cells_do_not_meet) {
  EXPECT_FALSE(find_overlap({seen(2, 0, 0), seen(3, 0, 0), seen(2, 1, 0), seen(2, 0, 1)}));
  // In no face's outer half space as a whole, and yet outside, beyond an edge.
  EXPECT_FALSE(find_overlap(
      {seen(-0.2, 0.1, 0.3), seen(0.1, -0.2, 0.3), seen(-0.2, 0.1, 0.2), seen(-0.3, 0.0, 0.3)}));
}

TEST(cell_overlap, may_be_a_face_or_a_corner) {
  EXPECT_DOUBLE_EQ(largest({seen(0, 0, 0), seen(1, 0, 0), seen(0, 1, 0), seen(0, 0, -1)}), 1);
  EXPECT_DOUBLE_EQ(largest({seen(1, 0, 0), seen(2, 0, 0), seen(2, 1, 0), seen(2, 0, 1)}), 1);
}

}  // namespace
}  // namespace lode
