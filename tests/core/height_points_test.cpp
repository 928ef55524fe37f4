#include "lode/core/height_points.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/oracles/random.h"

namespace lode {
namespace {

HeightPoints points_of(const std::vector<Vec3d>& points, const PointLattice& lattice,
                       RepeatedHeights repeated = RepeatedHeights::mean) {
  const auto made = to_height_points(points, lattice, repeated);
  EXPECT_TRUE(made) << made.error().message;
  return made ? *made : HeightPoints{};
}

/// UTM with centimetres, as LAS has it.
std::vector<Vec3d> survey(const PointLattice& lattice, int n) {
  oracles::Random random(1);
  std::vector<Vec3d> points;
  for (int i = 0; i < n; ++i)
    points.push_back({{lattice.origin[0] + lattice.step * std::floor(random.uniform(5e7, 5.1e7)),
                       lattice.origin[1] + lattice.step * std::floor(random.uniform(5e8, 5.1e8)),
                       std::floor(random.uniform(0, 100))}});
  return points;
}

TEST(height_points, keep_the_lattice_of_their_numbers_and_move_by_rounding_alone) {
  for (const PointLattice& lattice : {PointLattice{{0, 0}, 0.01}, {{500000, 4000000}, 0.01}}) {
    const HeightPoints made = points_of(survey(lattice, 500), lattice);
    EXPECT_EQ(made.step(), 0.01);
    EXPECT_LE(made.largest_move, 4e-9) << "more than a few units in the last place of 5e6";
    for (std::size_t i = 1; i < made.nodes.size(); ++i)
      EXPECT_LT(std::pair(made.nodes[i - 1].y, made.nodes[i - 1].x),
                std::pair(made.nodes[i].y, made.nodes[i].x));
  }
}

TEST(height_points, take_a_fitting_lattice_where_none_is_known_or_it_is_too_fine) {
  oracles::Random random(2);
  std::vector<Vec3d> points;
  for (int i = 0; i < 300; ++i)
    points.push_back(
        {{5e6 + random.uniform(0, 4000), random.uniform(-900, 900), random.uniform()}});
  for (const PointLattice& lattice : {PointLattice{}, {{0, 0}, 1e-9}}) {
    const HeightPoints made = points_of(points, lattice);
    EXPECT_EQ(made.step(), std::ldexp(1, 12 - 30));
    EXPECT_GT(made.largest_move, 0);
    EXPECT_LE(made.largest_move, made.step() * std::sqrt(0.5) * (1 + 1e-3));
    EXPECT_LE(made.n_columns, 1 << 30);
    for (const LatticePoint& node : made.nodes) {
      EXPECT_GE(std::min(node.x, node.y), 0);
      EXPECT_LT(node.x, made.n_columns);
      EXPECT_LT(node.y, made.n_rows);
    }
  }
}

TEST(height_points, are_one_where_several_share_a_position) {
  const std::vector<Vec3d> points{{{1, 1, 10}}, {{2, 1, 5}}, {{1, 1, 13}}, {{1, 1, 10}}};
  const PointLattice lattice{{0, 0}, 1};
  for (const auto& [repeated, height] : {std::pair{RepeatedHeights::mean, 11.0},
                                         {RepeatedHeights::lowest, 10.0},
                                         {RepeatedHeights::highest, 13.0}}) {
    const HeightPoints made = points_of(points, lattice, repeated);
    EXPECT_EQ(made.nodes, (std::vector<LatticePoint>{{0, 0}, {1, 0}}));
    EXPECT_EQ(made.heights, (std::vector<double>{height, 5}));
    EXPECT_EQ(made.n_repeated, 2U);
    EXPECT_EQ(made.largest_spread, 3);
  }
  const auto refused = to_height_points(points, lattice, RepeatedHeights::refused);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("3 at 1, 1, which differ by 3"), std::string::npos)
      << refused.error().message;
}

TEST(height_points, may_all_be_at_one_position_or_on_one_line) {
  const HeightPoints one = points_of({{{7, 8, 1}}, {{7, 8, 2}}}, {});
  EXPECT_EQ(one.nodes.size(), 1U);
  EXPECT_EQ(one.n_columns, 1);
  const HeightPoints line = points_of({{{0, 5, 1}}, {{1, 5, 2}}, {{2, 5, 2}}}, {});
  EXPECT_EQ(line.n_rows, 1);
  EXPECT_EQ(line.largest_move, 0);
  EXPECT_FALSE(to_height_points({}, {}, RepeatedHeights::mean));
}

TEST(height_points, have_a_lattice_whose_areas_doubles_hold_or_are_refused) {
  const auto spread = [](double size) {
    return std::vector<Vec3d>{{{-size, 0, 1}}, {{size, 0, 2}}, {{0, size, 3}}};
  };
  for (const double far : {1e150, 1e-140, 1e-300})
    for (const double step : {0.0, 1e-200}) {
      const HeightPoints made = points_of(spread(far), {{0, 0}, step});
      const double area = made.to_world[1] * made.to_world[5];
      EXPECT_TRUE(area > 0 && std::isfinite(area)) << area;
      for (const LatticePoint& node : made.nodes) EXPECT_GE(std::min(node.x, node.y), 0);
    }
  for (const double far : {1e151, 8e307, 1e308}) {
    const auto refused = to_height_points(spread(far), {}, RepeatedHeights::mean);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("from -1e+150 to 1e+150"), std::string::npos)
        << refused.error().message;
  }
}

TEST(height_points, have_a_mean_between_their_heights_however_large) {
  const HeightPoints made =
      points_of({{{0, 0, 1e9 + 0.01}}, {{0, 0, 1e9 + 0.02}}, {{0, 0, 1e9 + 0.02}}}, {});
  EXPECT_GE(made.heights[0], 1e9 + 0.01);
  EXPECT_LE(made.heights[0], 1e9 + 0.02);
}

}  // namespace
}  // namespace lode
