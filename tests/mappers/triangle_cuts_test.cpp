#include "lode/mappers/triangle_cuts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "tests/mappers/distance_oracle.h"

namespace lode::simplification {
namespace {

using test::triangle_distance;

double farthest_point(const Piece& t, const std::vector<Piece>& targets, int cuts = 24) {
  double farthest = 0;
  for (int i = 0; i <= cuts; ++i)
    for (int j = 0; i + j <= cuts; ++j) {
      const Vec3d p =
          t[0] + (t[1] - t[0]) * (double(i) / cuts) + (t[2] - t[0]) * (double(j) / cuts);
      double least = kUnproven;
      for (const Piece& target : targets) least = std::min(least, triangle_distance(p, target));
      farthest = std::max(farthest, least);
    }
  return farthest;
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

TEST(TriangleCuts, AreRightOfThree) {
  RandomTriangles random(1);
  int n_proven = 0;
  int n_by_one = 0;
  for (int i = 0; i < 4000; ++i) {
    const double flatness = random.number();
    const std::vector<Piece> targets{random.triangle(flatness), random.triangle(flatness),
                                     random.triangle(flatness)};
    Piece t = random.triangle(flatness);
    const double limit = random.number();
    std::array<std::size_t, 3> which{0, 1, 2};
    for (std::size_t& w : which)
      if (random.number() < 0.3) w = 0;
    const double bound =
        bound_by_cuts(t, {targets[0], targets[1], targets[2]}, which, limit * limit);
    if (bound == kUnproven) continue;
    ++n_proven;
    n_by_one += static_cast<int>(which == std::array<std::size_t, 3>{});
    EXPECT_LE(bound, limit * limit);
    EXPECT_LE(farthest_point(t, targets, 12), std::sqrt(bound) * (1 + 1e-9) + 1e-12) << i;
  }
  EXPECT_GT(n_proven, n_by_one + 100);
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
    if (!covers(t, targets, limit)) continue;
    ++n_proven;
    EXPECT_LE(farthest_point(t, targets), limit * (1 + 1e-9)) << i;
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
    EXPECT_TRUE(covers(t, fan, 1.02 * farthest + 0.02)) << i;
    EXPECT_FALSE(covers(t, fan, 0.99 * farthest)) << i;
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
  // Corners that are near one that is not looked at for them.
  EXPECT_EQ(bound_by_cuts(t, {left, right, right}, {1, 0, 0}, above), kUnproven);
  EXPECT_TRUE(covers(t, {left, right}, std::sqrt(above)));
  EXPECT_FALSE(covers(t, {left}, std::sqrt(above)));
  EXPECT_FALSE(covers(t, {}, 10));
}

}  // namespace
}  // namespace lode::simplification
