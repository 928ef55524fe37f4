#include "lode/locate/line_of_sight.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "tests/oracles/random.h"

namespace lode {
namespace {

constexpr double kEarth = 1 / 6371008.8;

/// A surface of the profile: at each place, and between them where wanted, off by shares of the
/// error. Whether the ray from and to it is free, by looking at many places, and by how little.
double clearance(const std::vector<SightPoint>& points, const SightOptions& options,
                 const std::function<double(double t)>& share) {
  const double length = points.back().distance;
  const double from =
      points.front().height + share(0) * points.front().error + options.observer_height;
  const double to = points.back().height + share(1) * points[points.size() - 2].error -
                    length * length * options.curvature / 2 + options.target_height;
  double least = INFINITY;
  constexpr int kSteps = 40;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    for (int k = 0; k <= kSteps; ++k) {
      // The ends as the limits of what lies between, too.
      const double s = std::clamp(static_cast<double>(k) / kSteps, 1e-9, 1 - 1e-9);
      const double d = points[i].distance + s * (points[i + 1].distance - points[i].distance);
      if (d <= 0 || d >= length) continue;
      const double z = points[i].height + s * (points[i + 1].height - points[i].height) +
                       share(d / length) * points[i].error - d * d * options.curvature / 2;
      least = std::min(least, from + d / length * (to - from) - z);
    }
  return least;
}

TEST(line_of_sight, answers_as_every_surface_within_the_bounds_does) {
  oracles::Random random(23);
  int n_of[3]{};
  for (int round = 0; round < 3000; ++round) {
    std::vector<SightPoint> points;
    double distance = 0;
    const double error = random.below(3) == 0 ? 0 : random.uniform(0, 3);
    const std::size_t n = 2 + random.below(9);
    for (std::size_t i = 0; i < n; ++i) {
      points.push_back({distance, random.uniform(0, 20), random.uniform(0, error), 0, false});
      distance += random.uniform(1, 4000);
    }
    const SightOptions options{.observer_height = random.uniform(0, 25),
                               .target_height = random.uniform(0, 25),
                               .curvature = random.below(2) == 0 ? 0 : kEarth};
    const SightAnswer answer = find_sight(points, options);
    ++n_of[static_cast<int>(answer.verdict)];
    // The surface that leaves most free, and the one that leaves least.
    const double most =
        clearance(points, options, [](double t) { return t == 0 || t == 1 ? 1 : -1; });
    const double least =
        clearance(points, options, [](double t) { return t == 0 || t == 1 ? -1 : 1; });
    constexpr double kSampled = 1e-9;
    switch (answer.verdict) {
      case SightVerdict::visible: EXPECT_GE(least, -kSampled); break;
      // Places between those looked at may stand higher by the bulge of a fortieth of a piece.
      case SightVerdict::blocked: EXPECT_LT(most, 1e-3); break;
      case SightVerdict::undecided:
        EXPECT_LT(least, 1e-3);
        EXPECT_GE(most, -kSampled);
        break;
    }
    for (int k = 0; k < 5; ++k) {
      const std::uint64_t seed = random.next();
      const double c = clearance(points, options, [&](double t) {
        oracles::Random here(seed + static_cast<std::uint64_t>(t * 1e9));
        return here.uniform(-1, 1);
      });
      if (answer.verdict == SightVerdict::visible) EXPECT_GE(c, -kSampled);
      if (answer.verdict == SightVerdict::blocked) EXPECT_LT(c, 1e-3);
    }
  }
  for (const int count : n_of) EXPECT_GT(count, 100) << "the test sees all three answers";
}

TEST(line_of_sight, finds_the_horizon_of_the_sea) {
  // Over a sphere an eye at h sees the surface to sqrt(2 h R).
  for (const double k : {0.0, 0.13})
    for (const double h : {1.8, 100.0}) {
      const double horizon = std::sqrt(2 * h / (kEarth * (1 - k)));
      for (const double share : {0.5, 0.99, 1.01, 2.0}) {
        const double length = horizon * share;
        std::vector<SightPoint> sea;
        for (int i = 0; i <= 10; ++i) sea.push_back({length * i / 10, 0, 0, 0, false});
        const SightAnswer answer =
            find_sight(sea, {.observer_height = h, .curvature = kEarth * (1 - k)});
        EXPECT_EQ(answer.verdict, share < 1 ? SightVerdict::visible : SightVerdict::blocked)
            << h << ' ' << share;
      }
    }
}

TEST(line_of_sight, lets_the_ray_touch_and_names_the_first_obstruction) {
  const auto wall = [](double height) {
    return std::vector<SightPoint>{{0, 0},   {100, 0},          {110, height}, {120, 0},
                                   {300, 0}, {310, 2 * height}, {320, 0},      {1000, 0}};
  };
  const SightOptions options{.observer_height = 10, .target_height = 10};
  EXPECT_EQ(find_sight(wall(9.99), options).verdict, SightVerdict::blocked) << "the second wall";
  EXPECT_EQ(find_sight(wall(9.99), options).worst.piece, 4U);
  EXPECT_EQ(find_sight(wall(4.99), options).verdict, SightVerdict::visible);
  const SightAnswer both = find_sight(wall(12), options);
  EXPECT_EQ(both.verdict, SightVerdict::blocked);
  EXPECT_DOUBLE_EQ(both.worst.distance, 110);
  EXPECT_NEAR(both.worst.low, 2, 1e-12);
  // At the end the target's own slope is touched, and that is exact.
  const std::vector<SightPoint> slope{{0, 0}, {100, -5}, {200, 10}};
  EXPECT_EQ(find_sight(slope, {.observer_height = 2}).verdict, SightVerdict::visible);
}

TEST(line_of_sight, holds_against_both_surfaces_at_a_step) {
  // Up to `left` in the middle, and down from `right`; eyes at 5 at both ends.
  const auto seen = [](double left, double right, double error) {
    const std::vector<SightPoint> points{
        {0, 0, 0, 0, false},          {40, 0, error, 0, false}, {50, left, 0, 0, false, true},
        {50, right, error, 0, false}, {60, 0, 0, 0, false},     {100, 0, 0, 0, false}};
    return find_sight(points, {.observer_height = 5, .target_height = 5});
  };
  EXPECT_EQ(seen(4, 2, 0).verdict, SightVerdict::visible) << "there is nothing to look through";
  EXPECT_EQ(seen(6, 2, 0).verdict, SightVerdict::blocked);
  EXPECT_EQ(seen(2, 6, 0).verdict, SightVerdict::blocked);
  EXPECT_FALSE(seen(2, 6, 0).has_gap);
  // The step itself, which states no error, decides nothing.
  EXPECT_EQ(seen(6, 2, 2).verdict, SightVerdict::undecided);
  EXPECT_EQ(seen(2, 6, 2).verdict, SightVerdict::undecided);
  EXPECT_EQ(seen(8, 2, 2).verdict, SightVerdict::blocked);
  EXPECT_EQ(seen(2, 2, 2).verdict, SightVerdict::visible);
}

TEST(line_of_sight, is_undecided_over_gaps_unless_blocked) {
  std::vector<SightPoint> way{{0, 0}, {100, 0, 0, 0, true}, {200, 0}, {300, 0}};
  const SightOptions options{.observer_height = 10, .target_height = 10};
  EXPECT_EQ(find_sight(way, options).verdict, SightVerdict::undecided);
  EXPECT_TRUE(find_sight(way, options).has_gap);
  way[2].height = 50;
  EXPECT_EQ(find_sight(way, options).verdict, SightVerdict::blocked);
}

}  // namespace
}  // namespace lode
