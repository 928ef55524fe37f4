#include "lode/mappers/surface_match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/mappers/shape_surfaces.h"
#include "tests/oracles/random.h"

namespace lode {
namespace {

constexpr double kDistance = 1e-6;

/// The same cells and vertices in another order, each cell from another corner on, moved a little.
Surface shuffled(const Surface& surface, oracles::Random& random) {
  std::vector<std::uint32_t> place(surface.positions.size());
  std::iota(place.begin(), place.end(), 0U);
  for (std::size_t i = place.size(); i > 1; --i) std::swap(place[i - 1], place[random.below(i)]);
  Surface result = surface;
  for (std::size_t v = 0; v < place.size(); ++v) {
    result.positions[place[v]] = surface.positions[v];
    result.positions[place[v]][0] += static_cast<float>(random.uniform(-0.5e-6, 0.5e-6));
  }
  for (auto& t : result.triangles) {
    for (std::uint32_t& v : t) v = place[v];
    std::rotate(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(random.below(3)), t.end());
  }
  for (std::size_t i = result.triangles.size(); i > 1; --i)
    std::swap(result.triangles[i - 1], result.triangles[random.below(i)]);
  return result;
}

TEST(surface_match, finds_the_same_cells_in_any_order) {
  const Surface torus = test::make_torus(19, 11, 2.0, 0.5);
  EXPECT_TRUE(match_surfaces(torus, torus, 0x1p-1000).is_same());
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    oracles::Random random(seed);
    EXPECT_TRUE(match_surfaces(torus, shuffled(torus, random), kDistance).is_same());
  }
}

TEST(surface_match, counts_what_is_missing_added_or_turned) {
  const Surface torus = test::make_torus(19, 11, 2.0, 0.5);
  oracles::Random random(3);
  Surface other = shuffled(torus, random);
  std::swap(other.triangles[7][0], other.triangles[7][1]);
  std::swap(other.triangles[9][1], other.triangles[9][2]);
  other.triangles.erase(other.triangles.begin() + 20, other.triangles.begin() + 25);
  other.triangles.push_back(other.triangles[0]);
  const MatchReport report = match_surfaces(torus, other, kDistance);
  EXPECT_EQ(report.n_cells, torus.triangles.size() - 4);
  EXPECT_EQ(report.n_turned, 2U);
  EXPECT_EQ(report.first_turned, 7U);
  EXPECT_EQ(report.n_missing, 5U);
  EXPECT_EQ(report.n_extra, 1U);
  EXPECT_EQ(report.first_extra, other.triangles.size() - 1);
  EXPECT_FALSE(report.is_same());
}

TEST(surface_match, a_vertex_moved_too_far_takes_its_cells_along) {
  const Surface sphere = test::make_sphere(9, 1.0, {{0, 0, 0}});
  Surface moved = sphere;
  moved.positions[0][2] -= 1e-3F;
  const MatchReport report = match_surfaces(sphere, moved, kDistance);
  EXPECT_EQ(report.n_missing, 18U);
  EXPECT_EQ(report.n_extra, 18U);
  EXPECT_EQ(report.n_turned, 0U);
}

TEST(surface_match, lines_have_a_direction) {
  Surface square;
  square.positions = {test::point(0, 0, 0), test::point(1, 0, 0), test::point(1, 1, 0)};
  square.lines = {{0, 1}, {1, 2}, {2, 0}};
  Surface other = square;
  std::swap(other.lines[0], other.lines[2]);
  EXPECT_TRUE(match_surfaces(square, other, kDistance).is_same());
  std::swap(other.lines[1][0], other.lines[1][1]);
  EXPECT_EQ(match_surfaces(square, other, kDistance).n_turned, 1U);
  EXPECT_EQ(match_surfaces(square, {}, kDistance).n_missing, 3U);
  EXPECT_EQ(match_surfaces({}, square, kDistance).n_extra, 3U);
}

}  // namespace
}  // namespace lode
