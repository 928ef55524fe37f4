#include "lode/locate/polygon_locator.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/oracles/random.h"

namespace lode {
namespace {

using Place = Vec<double, 2>;
using oracles::Random;

/// By the definition, of small whole numbers: on an edge, or an odd number of edges cross the ray
/// to the right.
bool is_in(const PlacePolygon& polygon, const Place& p) {
  bool is_inside = false;
  for (const auto& ring : polygon)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Place& a = ring[i];
      const Place& b = ring[(i + 1) % ring.size()];
      const double turn = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
      const double along = (p[0] - a[0]) * (p[0] - b[0]) + (p[1] - a[1]) * (p[1] - b[1]);
      if (turn == 0 && along <= 0) return true;
      if ((a[1] > p[1]) == (b[1] > p[1])) continue;
      if ((turn > 0) == (b[1] > a[1])) is_inside = !is_inside;
    }
  return is_inside;
}

std::vector<Place> random_ring(Random& random, std::uint64_t n, std::uint64_t size) {
  std::vector<Place> ring;
  for (std::uint64_t i = 0; i < n; ++i)
    ring.push_back(
        {{static_cast<double>(random.below(size)), static_cast<double>(random.below(size))}});
  return ring;
}

TEST(polygon_locator, finds_what_is_in_any_polygon_or_on_a_border) {
  Random random(4);
  for (int round = 0; round < 200; ++round) {
    const std::uint64_t size = 3 + random.below(30);
    std::vector<PlacePolygon> polygons;
    for (std::uint64_t i = 0; i <= random.below(3); ++i) {
      polygons.emplace_back();
      for (std::uint64_t k = 0; k <= random.below(3); ++k)
        polygons.back().push_back(random_ring(random, 3 + random.below(40), size));
    }
    const PolygonLocator locator(polygons);
    for (double y = -1; y <= static_cast<double>(size); y += 0.5)
      for (double x = -1; x <= static_cast<double>(size); x += 0.5) {
        const Place p{{x, y}};
        const bool expected = std::ranges::any_of(
            polygons, [&](const PlacePolygon& polygon) { return is_in(polygon, p); });
        ASSERT_EQ(locator.holds(p), expected) << x << ", " << y << " in round " << round;
      }
  }
}

TEST(polygon_locator, takes_rings_that_are_closed_flat_or_not_there) {
  EXPECT_FALSE(PolygonLocator({}).holds({{0, 0}}));
  const std::vector<PlacePolygon> flat{{{{{0, 5}}, {{9, 5}}, {{4, 5}}}}};
  EXPECT_TRUE(PolygonLocator(flat).holds({{3, 5}}));
  EXPECT_FALSE(PolygonLocator(flat).holds({{3, 6}}));
  const std::vector<PlacePolygon> closed{{{{{0, 0}}, {{9, 0}}, {{0, 9}}, {{0, 0}}}}};
  EXPECT_TRUE(PolygonLocator(closed).holds({{1, 1}}));
  EXPECT_FALSE(PolygonLocator(closed).holds({{8, 8}}));
}

/// Nearly all edges of a comb reach over all bands.
TEST(polygon_locator, is_small_of_edges_that_are_all_long) {
  constexpr int kTeeth = 50000;
  std::vector<Place> comb;
  for (int i = 0; i < kTeeth; ++i)
    comb.push_back({{static_cast<double>(i), i % 2 == 0 ? 0.0 : 1e6}});
  comb.push_back({{kTeeth, -1}});
  comb.push_back({{-1, -1}});
  const std::vector<PlacePolygon> polygons{{comb}};
  const PolygonLocator locator(polygons);
  EXPECT_TRUE(locator.holds({{101, 5e5}}));
  EXPECT_FALSE(locator.holds({{100, 5e5}}));
}

}  // namespace
}  // namespace lode
