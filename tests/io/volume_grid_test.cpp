#include <cmath>

#include "lode/io/image_grid.h"
#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

TEST(grid_maker, keeps_axis_aligned_steps_exactly) {
  const auto grid = make_grid(
      "f",
      GridSteps{.dims = {{2, 2, 2}},
                .steps = {{Vec3d{{0, 0, -0.7}}, Vec3d{{1e-200, 0, 0}}, Vec3d{{0, 1e200, 0}}}}});
  ASSERT_TRUE(grid) << grid.error().message;
  EXPECT_EQ(grid->spacing, (Vec3d{{0.7, 1e-200, 1e200}}));
  EXPECT_EQ(grid->direction.column(0), (Vec3d{{0, 0, -1}}));
  EXPECT_EQ(grid->direction.column(1), (Vec3d{{1, 0, 0}}));
}

TEST(grid_maker, gives_a_thin_axis_without_a_step_a_perpendicular_one) {
  const auto plane = make_grid(
      "f", GridSteps{.dims = {{2, 2, 1}}, .steps = {{Vec3d{{0, 2, 0}}, Vec3d{{0, 0, 3}}, {}}}});
  ASSERT_TRUE(plane) << plane.error().message;
  EXPECT_EQ(plane->spacing[2], 1);
  EXPECT_EQ(plane->direction.column(2), (Vec3d{{1, 0, 0}}));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    GridSteps line{.dims = {{2, 1, 1}}, .steps = {}};
    line.steps[0][axis] = 1;
    const auto grid = make_grid("f", line);
    ASSERT_TRUE(grid) << grid.error().message;
    EXPECT_NEAR(std::abs(determinant(grid->direction)), 1, 1e-15);
  }
}

TEST(grid_maker, moves_the_length_of_a_direction_into_the_spacing) {
  GridFrame frame{.dims = {{2, 2, 2}}, .spacing = {{0.1, 0.2, 0.3}}};
  frame.direction.rows[1][1] = -2;
  const auto grid = make_grid("f", frame);
  ASSERT_TRUE(grid) << grid.error().message;
  EXPECT_EQ(grid->spacing, (Vec3d{{0.1, 0.4, 0.3}}));
  EXPECT_EQ(grid->direction.column(1), (Vec3d{{0, -1, 0}}));
}

TEST(axis_fitter, accepts_float32_longitudes_and_descending_axes) {
  std::vector<double> positions;
  for (int i = 0; i < 4320; ++i)
    positions.push_back(double{static_cast<float>(0.5 / 12 + i / 12.0)});
  const auto axis = fit_uniform_axis("f", 'x', positions, AxisPrecision::float32);
  ASSERT_TRUE(axis) << axis.error().message;
  EXPECT_NEAR(axis->step, 1.0 / 12, 1e-7);
  std::reverse(positions.begin(), positions.end());
  const auto reversed = fit_uniform_axis("f", 'x', positions, AxisPrecision::float32);
  ASSERT_TRUE(reversed) << reversed.error().message;
  EXPECT_NEAR(reversed->step, -1.0 / 12, 1e-7);
}

TEST(axis_fitter, names_the_axis_and_the_largest_deviation) {
  const std::vector<double> positions = {0, 1, 2.25, 3};
  const auto axis = fit_uniform_axis("file", 'y', positions, AxisPrecision::float64);
  ASSERT_FALSE(axis);
  EXPECT_NE(axis.error().message.find("axis y"), std::string::npos);
  EXPECT_NE(axis.error().message.find("0.25"), std::string::npos);
  EXPECT_FALSE(fit_uniform_axis("f", 'y', std::vector<double>{0, NAN}, AxisPrecision::float64));
}

}  // namespace
}  // namespace lode::io
