#include "lode/mappers/triangle_cuts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/mappers/distance_oracle.h"

namespace lode::simplification {
namespace {

using test::triangle_distance;

/// How far its points are from the nearest target: on a grid, and from the farthest of these on.
double farthest_point(const Piece& t, const std::vector<Piece>& targets, int cuts = 16) {
  const auto distance = [&](double u, double v) {
    const Vec3d p = t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v;
    double least = kUnproven;
    for (const Piece& target : targets) least = std::min(least, triangle_distance(p, target));
    return least;
  };
  std::array<double, 3> best{0, 0, -1};  // two shares, and the distance
  const auto look_at = [&](double u, double v) {
    if (u < 0 || v < 0 || u + v > 1) return;
    if (const double here = distance(u, v); here > best[2]) best = {u, v, here};
  };
  for (int i = 0; i <= cuts; ++i)
    for (int j = 0; i + j <= cuts; ++j) look_at(double(i) / cuts, double(j) / cuts);
  for (double step = 1.0 / cuts; step > 1e-7;) {
    const std::array<double, 3> from = best;
    for (const auto& [du, dv] : {std::array{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, -1}, {-1, 1}})
      look_at(from[0] + step * du, from[1] + step * dv);
    if (best == from) step *= 0.5;
  }
  return best[2];
}

bool covers(const Piece& t, const std::vector<Piece>& targets, double limit) {
  TriangleCuts cuts;
  cuts.begin(t, limit);
  for (const Piece& target : targets) cuts.add(target);
  return cuts.covers();
}

/// The triangles round the middle of a regular polygon, which is `height` over its corners.
std::vector<Piece> make_fan(std::size_t n, double height) {
  const auto corner = [&](std::size_t i) {
    const double angle = 6.283185307179586 * static_cast<double>(i) / static_cast<double>(n);
    return Vec3d{{std::cos(angle), std::sin(angle), 0}};
  };
  std::vector<Piece> fan;
  for (std::size_t i = 0; i < n; ++i)
    fan.push_back({Vec3d{{0, 0, height}}, corner(i), corner(i + 1)});
  return fan;
}

class RandomTriangles {
 public:
  explicit RandomTriangles(unsigned seed) : random_(seed) {}
  Vec3d point(double flatness) {
    return {{across_(random_), across_(random_), flatness * across_(random_)}};
  }
  Piece triangle(double flatness) { return {point(flatness), point(flatness), point(flatness)}; }
  double number() { return 0.5 * (across_(random_) + 1); }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> across_{-1, 1};
};

std::size_t nearest_of(const std::vector<Piece>& targets, const Vec3d& p) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < targets.size(); ++i)
    if (triangle_distance(p, targets[i]) < triangle_distance(p, targets[nearest])) nearest = i;
  return nearest;
}

/// Of targets that are each near a corner, so that what is between these decides.
TEST(TriangleCuts, AreRightOfThree) {
  RandomTriangles random(1);
  int n_of_three = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double flatness = random.number();
    const Piece t = random.triangle(flatness);
    std::vector<Piece> targets;
    for (const Vec3d& corner : t) {
      const double reach = random.number();
      Piece target = random.triangle(flatness);
      for (Vec3d& p : target) p = corner + p * reach;
      targets.push_back(target);
    }
    std::array<std::size_t, 3> which{};
    for (std::size_t k = 0; k < 3; ++k) which[k] = nearest_of(targets, t[k]);
    const double limit = random.number();
    const double bound =
        bound_by_cuts(t, {targets[0], targets[1], targets[2]}, which, limit * limit);
    if (bound == kUnproven) continue;
    n_of_three +=
        static_cast<int>(which[0] != which[1] && which[1] != which[2] && which[2] != which[0]);
    EXPECT_LE(bound, limit * limit);
    EXPECT_LE(farthest_point(t, targets), std::sqrt(bound) * (1 + 1e-9) + 1e-12) << i;
  }
  EXPECT_GT(n_of_three, 1000);
}

TEST(TriangleCuts, AreRightOfMany) {
  RandomTriangles random(2);
  int n_proven = 0;
  for (int i = 0; i < 300; ++i) {
    const double flatness = random.number();
    std::vector<Piece> targets;
    const std::size_t n = i % 7 == 0 ? 300 : 3 + static_cast<std::size_t>(i) % 30;
    for (std::size_t k = 0; k < n; ++k) targets.push_back(random.triangle(flatness));
    // Some have no area, or are points.
    if (i % 3 == 0) targets[0][2] = targets[0][1];
    if (i % 5 == 0) targets[1][2] = targets[1][1] = targets[1][0];
    const Piece t = random.triangle(flatness);
    const double limit = 0.4 * random.number();
    const double farthest = farthest_point(t, targets);
    EXPECT_FALSE(covers(t, targets, farthest * (1 - 1e-4))) << i;
    if (!covers(t, targets, limit)) continue;
    ++n_proven;
    EXPECT_LE(farthest, limit * (1 + 1e-9)) << i;
  }
  EXPECT_GT(n_proven, 50);
  EXPECT_LT(n_proven, 280);
}

/// What is asked for most: over the middle of a fan, or across some of its triangles.
TEST(TriangleCuts, FindTheWayAcrossAFan) {
  RandomTriangles random(3);
  for (int i = 0; i < 400; ++i) {
    const std::vector<Piece> fan = make_fan(3 + static_cast<std::size_t>(i) % 12, random.number());
    Piece t = random.triangle(0);
    for (Vec3d& p : t) {  // over the fan
      p = p * 0.3;
      double least = kUnproven;
      for (const Piece& target : fan) least = std::min(least, triangle_distance(p, target));
      p[2] += least;
    }
    const double farthest = farthest_point(t, fan);
    EXPECT_TRUE(covers(t, fan, 1.01 * farthest + 0.01)) << i;
    EXPECT_FALSE(covers(t, fan, (1 - 1e-6) * farthest)) << i;
  }
}

TEST(TriangleCuts, CutBetweenTwoAtOnePoint) {
  // A roof, and a triangle that touches both sides of it from above.
  const Piece left{Vec3d{{-1, -1, -1}}, Vec3d{{0, -1, 0}}, Vec3d{{0, 1, 0}}};
  const Piece right{Vec3d{{1, -1, -1}}, Vec3d{{0, 1, 0}}, Vec3d{{0, -1, 0}}};
  const Piece t{Vec3d{{-0.5, -0.5, 0}}, Vec3d{{0.5, -0.5, 0}}, Vec3d{{0.5, -0.4, 0}}};
  const double at_ends = std::sqrt(0.125);
  const double above = at_ends * at_ends * (1 + 1e-12);
  EXPECT_NEAR(bound_by_cuts(t, {left, right, right}, {0, 1, 1}, above), 0.125, 1e-9);
  EXPECT_EQ(bound_by_cuts(t, {left, right, right}, {0, 1, 1}, 0.124), kUnproven);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Piece nowhere{Vec3d{{nan, nan, nan}}, Vec3d{{nan, nan, nan}}, Vec3d{{nan, nan, nan}}};
  EXPECT_EQ(bound_by_cuts(t, {nowhere, nowhere, nowhere}, {0, 0, 0}, 1), kUnproven);
  EXPECT_FALSE(covers(t, {nowhere}, 10));
  // Corners that are near one that is not looked at for them.
  EXPECT_EQ(bound_by_cuts(t, {left, right, right}, {1, 0, 0}, above), kUnproven);
  EXPECT_TRUE(covers(t, {left, right}, std::sqrt(above)));
  EXPECT_FALSE(covers(t, {left}, std::sqrt(above)));
  EXPECT_FALSE(covers(t, {}, 10));
}

}  // namespace
}  // namespace lode::simplification
