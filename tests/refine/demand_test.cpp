// Demands must not decrease when error, range or bounds grow: the engine's answers hang on it.

#include "lode/refine/demand.h"

#include <gtest/gtest.h>

#include <cmath>

#include <random>

#include "lode/refine/focus.h"

namespace lode::test {
namespace {

class demand : public ::testing::Test {
 protected:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vec3d point() { return {{uniform(-10, 10), uniform(-10, 10), uniform(-10, 10)}}; }

  NodeFacts node() {
    NodeFacts facts;
    facts.error = random_() % 10 == 0 ? 0 : uniform(0, 20);
    facts.world_error = uniform(0, 3);
    facts.range.low = uniform(-10, 100);
    facts.range.high = facts.range.low + uniform(-1, 20);
    facts.bounds = {point(), uniform(0, 6)};
    if (random_() % 2 == 0) facts.bounds.half = {{uniform(0, 4), uniform(0, 4), uniform(0, 4)}};
    if (random_() % 4 == 0) facts.bounds.radius = 0;
    facts.is_at_border = random_() % 4 == 0;
    return facts;
  }
  /// The same node or one above it.
  NodeFacts grown(NodeFacts facts) {
    facts.error += random_() % 2 == 0 ? 0 : uniform(0, 5);
    facts.world_error += random_() % 2 == 0 ? 0 : uniform(0, 1);
    if (facts.range.is_empty()) facts.range = {uniform(0, 10), uniform(10, 20)};
    facts.range.low -= random_() % 2 == 0 ? 0 : uniform(0, 5);
    facts.range.high += random_() % 2 == 0 ? 0 : uniform(0, 5);
    const Vec3d step = point() * uniform(0, 0.2);
    facts.bounds.centre = facts.bounds.centre + step;
    if (random_() % 2 == 0) {
      for (std::size_t i = 0; i < 3; ++i)
        facts.bounds.half[i] += std::abs(step[i]) * (1 + 1e-12) + 1e-12 + uniform(0, 1);
    } else {
      facts.bounds.radius += length(step) * (1 + 1e-12) + 1e-12 + uniform(0, 1);
    }
    facts.is_at_border = facts.is_at_border || random_() % 4 == 0;
    return facts;
  }

  ViewFocus view() {
    ViewFocus focus;
    focus.eye = point();
    focus.pixels_per_radian = uniform(10, 2000);
    for (auto& plane : focus.planes) {
      plane.normal = normalized(point());
      plane.offset = dot(plane.normal, focus.eye);
    }
    return focus;
  }

  Focus focus(int kind) {
    const Vec3d p = point();
    switch (kind) {
      case 0: return IsovalueFocus{{uniform(0, 100), uniform(0, 100)}};
      case 1: return IntervalFocus{{{uniform(0, 50), uniform(50, 100)}}};
      case 2: return BoxFocus{{p, p + Vec3d{{uniform(0, 5), uniform(0, 5), uniform(0, 5)}}}};
      case 3: return BallFocus{{p, uniform(0, 5)}};
      case 4: return HalfSpaceFocus{p, point()};
      case 5: return SectionFocus{p, point()};
      case 6: return OpacityFocus{{{10, 0}, {uniform(20, 40), 0.5}, {50, 0}, {60, uniform(0, 1)}}};
      default: return view();
    }
  }

  FocusDemand focus_demand() {
    FocusDemand built_in;
    for (std::size_t n = random_() % 3; n > 0; --n)
      built_in.foci.push_back(focus(static_cast<int>(random_() % 8)));
    built_in.inside = random_() % 5 == 0 ? 0 : uniform(0, 10);
    if (random_() % 2 == 0) built_in.outside = uniform(0, 20);
    built_in.unit = static_cast<ErrorUnit>(random_() % 3);
    built_in.view = view();
    built_in.ends_at_border = random_() % 2 == 0;
    return built_in;
  }

  void expect_monotone(const Demand& some) {
    for (int i = 0; i < 200; ++i) {
      const NodeFacts below = node();
      const NodeFacts above = grown(below);
      ASSERT_LE(some(below), some(above));
      ASSERT_TRUE(some.touches(above) || !some.touches(below));
      // What a focus leaves alone is never wanted.
      ASSERT_TRUE(some.touches(below) || some(below) <= 0);
    }
  }

  std::mt19937 random_{7};
};

TEST(bounds, contain_what_lies_within_a_distance_of_a_box) {
  const Bounds outer{{{1, 2, 3}}, 0.5, {{2, 0, 1}}};
  EXPECT_TRUE(outer.contains(outer));
  EXPECT_TRUE(outer.contains({{{3, 2, 3}}, 0.5}));
  EXPECT_FALSE(outer.contains({{{3.1, 2, 3}}, 0.5}));
  EXPECT_TRUE(outer.contains({{{3.25, 2.25, 3}}, 0.1}));
  EXPECT_FALSE(outer.contains({{{3.45, 2.45, 3}}, 0}));  // beyond the rounded edge
  EXPECT_TRUE(outer.contains({{{1, 2, 3}}, 0, {{2.5, 0, 1}}}));
  EXPECT_FALSE(outer.contains({{{1, 2, 3}}, 0, {{2.5, 0.5, 1}}}));
  EXPECT_DOUBLE_EQ(outer.beyond({{6, 6, 3}}), 5);
  EXPECT_DOUBLE_EQ(outer.reach({{0.6, 0, -0.8}}), 0.5 + 1.2 + 0.8);
}

TEST_F(demand, is_monotone_for_every_focus_and_unit) {
  for (int i = 0; i < 3000; ++i) expect_monotone(focus_demand());
}

TEST_F(demand, is_monotone_when_joined) {
  for (int i = 0; i < 500; ++i) {
    const std::vector<Demand> parts{focus_demand(), focus_demand(), focus_demand()};
    expect_monotone(max_of(parts));
    expect_monotone(min_of(parts));
    expect_monotone(sum_of({max_of({parts[0], parts[1]}), parts[2]}));
  }
}

TEST_F(demand, refines_everything_at_tolerance_zero) {
  for (int i = 0; i < 100; ++i) EXPECT_GT(uniform_demand(0)(node()), 0);
}

TEST_F(demand, touches_opacity_between_its_ends) {
  FocusDemand opaque;
  opaque.foci = {OpacityFocus{{{10, 0}, {20, 1}, {30, 0}}}};
  NodeFacts facts = node();
  facts.range = {12, 13};
  EXPECT_TRUE(opaque.touches(facts));
  facts.range = {0, 9};
  EXPECT_FALSE(opaque.touches(facts));
  facts.range = {0, 100};
  EXPECT_TRUE(opaque.touches(facts));
  facts.range = {31, 100};
  EXPECT_FALSE(opaque.touches(facts));
}

TEST_F(demand, counts_errors_by_the_share_of_the_largest_opacity) {
  FocusDemand opaque;
  opaque.foci = {OpacityFocus{{{10, 0}, {20, 4}, {30, 1}}}};
  opaque.inside = 3;
  NodeFacts facts = node();
  facts.error = 8;
  facts.range = {11, 15};
  EXPECT_DOUBLE_EQ(opaque(facts), 1);  // half as opaque as may be
  facts.range = {40, 50};
  EXPECT_DOUBLE_EQ(opaque(facts), 0);
  facts.range = {0, 50};
  EXPECT_DOUBLE_EQ(opaque(facts), 5);
  opaque.outside = 6;
  facts.range = {11, 15};
  EXPECT_DOUBLE_EQ(opaque(facts), 2);
}

TEST_F(demand, measures_pixels_from_the_near_side_of_a_ball) {
  ViewFocus focus;
  focus.pixels_per_radian = 1000;
  EXPECT_DOUBLE_EQ(focus.pixels(0.5, {{{10, 0, 0}}, 5}), 100);
  EXPECT_EQ(focus.pixels(0.5, {{{3, 0, 0}}, 5}), std::numeric_limits<double>::infinity());
  EXPECT_EQ(focus.pixels(0, {{{3, 0, 0}}, 5}), 0);
}

TEST_F(demand, is_a_users_own_function_as_well) {
  const Demand own = [](const NodeFacts& facts) { return 2 * facts.error; };
  NodeFacts facts = node();
  facts.error = 3;
  EXPECT_EQ(own(facts), 6);
  EXPECT_TRUE(own.touches(facts));
}

}  // namespace
}  // namespace lode::test
