#include "lode/mappers/shadow_cover.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/mappers/distance_oracle.h"
#include "tests/mappers/shape_surfaces.h"
#include "tests/oracles/trials.h"

namespace lode::simplification {
namespace {

using test::corners_of;
using test::DistanceTarget;

/// A surface, and what is round its vertices.
struct Original {
  explicit Original(Surface from) : surface(std::move(from)), first(surface.positions.size() + 1) {
    for (const auto& t : surface.triangles)
      for (const std::uint32_t v : t) ++first[v + 1];
    for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
    around.resize(first.back());
    std::vector<std::uint32_t> at(first.begin(), first.end() - 1);
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
      for (const std::uint32_t v : surface.triangles[t]) around[at[v]++] = t;
  }
  [[nodiscard]] double bound(const Piece& triangle, std::uint32_t start, double limit) const {
    ShadowCover cover(surface, {first, around}, limit);
    return cover.bound(triangle, start);
  }
  /// The same, and where that is not enough from another start too.
  [[nodiscard]] double bound(const Piece& triangle, std::uint32_t start, std::uint32_t second,
                             double limit) const {
    ShadowCover cover(surface, {first, around}, limit);
    const double bound = cover.bound(triangle, start);
    return bound < kUnproven ? bound : cover.bound_with(second);
  }
  /// Cells of an n by n piece of a triangle that shadows from `start` cover where not all of it is.
  [[nodiscard]] std::vector<std::size_t> covered_cells(const Piece& triangle, const Piece& piece,
                                                       std::uint32_t start, double limit,
                                                       std::size_t n) const {
    ShadowCover cover(surface, {first, around}, limit);
    std::vector<std::size_t> cells;
    if (cover.bound(triangle, start) < kUnproven || !cover.has_rims()) return cells;
    std::vector<std::int32_t> is_covered(n * n);
    cover.mark_covered(piece, n, radius_of(cell_of(piece, 0, n)), is_covered);
    for (std::size_t i = 0; i < n * n; ++i)
      if (is_covered[i] != 0) cells.push_back(i);
    return cells;
  }
  [[nodiscard]] std::uint32_t nearest(const Vec3d& p) const {
    std::uint32_t best = 0;
    for (std::uint32_t v = 1; v < surface.positions.size(); ++v)
      if (length(widened(surface.positions[v]) - p) < length(widened(surface.positions[best]) - p))
        best = v;
    return best;
  }

  Surface surface;
  std::vector<std::uint32_t> first;
  std::vector<std::uint32_t> around;
};

double largest_distance(const Piece& t, DistanceTarget& target, int cuts = 12) {
  double largest = 0;
  for (int i = 0; i <= cuts; ++i)
    for (int j = 0; i + j <= cuts; ++j)
      largest = std::max(largest, target.distance(t[0] + (t[1] - t[0]) * (double(i) / cuts) +
                                                  (t[2] - t[0]) * (double(j) / cuts)));
  return largest;
}

/// Over [0, n]², up to `height` high at random.
Surface make_rough_patch(std::uint32_t n, double height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> up(0, height);
  return test::make_patch(n, [&](std::uint32_t, std::uint32_t) { return up(random); });
}

struct Tally {
  int n_proven = 0;
  int n_near = 0;
  std::size_t n_cells = 0;  ///< Of others, that are covered.
};

constexpr int kTriangles = 1000;

/// Random triangles with corners within `off` of vertices of the surface, up to `size` apart. What
/// is proven is held against distances found at points.
Tally try_triangles(const Original& original, double size, double off, double limit) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> shift(-off, off);
  DistanceTarget target(original.surface);
  const auto& positions = original.surface.positions;
  Tally tally;
  for (int i = 0; i < kTriangles; ++i) {
    const Vec3d middle = widened(positions[random() % positions.size()]);
    Piece piece;
    for (Vec3d& corner : piece) {
      do corner = widened(positions[random() % positions.size()]);
      while (length(corner - middle) > size);
      for (std::size_t k = 0; k < 3; ++k) corner[k] += shift(random);
    }
    const std::uint32_t start = original.nearest((piece[0] + piece[1] + piece[2]) * (1.0 / 3));
    const double bound = std::sqrt(original.bound(piece, start, limit));
    const double found = largest_distance(piece, target);
    if (found <= limit) ++tally.n_near;
    constexpr std::size_t kCells = 7;
    for (const Piece& part : {piece, quarters(piece)[random() % 4]}) {
      if (i % 4 != 0) break;  // these take longest
      for (const std::size_t cell : original.covered_cells(piece, part, start, limit, kCells)) {
        ++tally.n_cells;
        EXPECT_LE(largest_distance(cell_of(part, cell, kCells), target, 2), limit + 1e-12);
      }
    }
    const double of_two = std::sqrt(original.bound(piece, original.nearest(middle), start, limit));
    if (of_two <= limit) EXPECT_LE(found, of_two * (1 + 1e-9) + 1e-12);
    if (!(bound <= limit)) continue;
    ++tally.n_proven;
    EXPECT_LE(found, bound * (1 + 1e-9) + 1e-12);
  }
  return tally;
}

TEST(shadow_cover, proves_most_triangles_near_a_smooth_surface) {
  const Tally tally = try_triangles(Original(test::make_sphere(20, 7, {{3, 2, 1}})), 2, 0.1, 0.6);
  EXPECT_GT(tally.n_near, kTriangles / 2);
  EXPECT_GT(tally.n_proven, tally.n_near / 2);
}

TEST(shadow_cover, never_proves_what_is_farther) {
  for (unsigned seed = 0; seed < oracles::trials(4U, 2U); ++seed) {
    // Of rough surfaces, limits that just hold, just do not, and cut through.
    const Original patch(make_rough_patch(14, 0.4 + 0.5 * seed, seed));
    for (const double limit : {0.2, 0.5, 1.0}) {
      const Tally tally = try_triangles(patch, 4, 0.4, limit);
      EXPECT_LT(tally.n_proven, kTriangles);
      EXPECT_GT(tally.n_cells, 0);
    }
  }
  // Both sides of thin ones are near their triangles, and tubes close behind them.
  EXPECT_GT(try_triangles(Original(test::make_torus(60, 8, 10, 0.4)), 2, 0.3, 0.5).n_proven, 0);
  EXPECT_GT(try_triangles(Original(test::make_torus(30, 12, 3, 1)), 3, 0.3, 0.8).n_proven, 0);
}

TEST(shadow_cover, a_triangle_beyond_the_border_is_not_covered) {
  const Original patch(make_rough_patch(10, 0, 1));
  const Piece inside{Vec3d{{1.2, 1.3, 0.1}}, Vec3d{{7.1, 2.2, 0.1}}, Vec3d{{3.3, 8.4, 0.1}}};
  EXPECT_NEAR(patch.bound(inside, patch.nearest({{3, 3, 0}}), 0.2), 0.01, 1e-7);
  EXPECT_EQ(patch.bound(inside, patch.nearest({{3, 3, 0}}), 0.05), kUnproven);
  const Piece beyond{Vec3d{{1.2, 1.3, 0.1}}, Vec3d{{10.5, 2.2, 0.1}}, Vec3d{{3.3, 8.4, 0.1}}};
  EXPECT_EQ(patch.bound(beyond, patch.nearest({{3, 3, 0}}), 0.2), kUnproven);
  // Nothing is found from a start that is elsewhere.
  EXPECT_EQ(patch.bound(inside, patch.nearest({{10, 10, 0}}), 0.2), kUnproven);
}

TEST(shadow_cover, a_hole_is_not_covered) {
  Surface surface = make_rough_patch(10, 0, 1);
  const auto t = surface.triangles.begin() + 2 * (4 * 10 + 4);
  surface.triangles.erase(t, t + 2);
  const Original patch(surface);
  const Piece over{Vec3d{{1.2, 1.3, 0}}, Vec3d{{9.1, 1.2, 0}}, Vec3d{{5.3, 9.4, 0}}};
  EXPECT_EQ(patch.bound(over, patch.nearest({{4, 2, 0}}), 0.2), kUnproven);
  // Around it: of ten by ten cells all but those near [4, 5]².
  const auto cells = patch.covered_cells(over, over, patch.nearest({{4, 2, 0}}), 0.2, 8);
  EXPECT_GT(cells.size(), 48U);
  EXPECT_LT(cells.size(), 64U);
  for (const std::size_t cell : cells) {
    const Piece c = cell_of(over, cell, 8);
    const Vec3d middle = (c[0] + c[1] + c[2]) * (1.0 / 3);
    EXPECT_TRUE(middle[0] < 4 || middle[0] > 5 || middle[1] < 4 || middle[1] > 5);
  }
  const Piece beside{Vec3d{{1.2, 1.3, 0}}, Vec3d{{9.1, 1.2, 0}}, Vec3d{{5.3, 3.4, 0}}};
  EXPECT_LT(patch.bound(beside, patch.nearest({{5, 2, 0}}), 0.2), 1e-9);
}

/// A pillow on the sheet's edge, which three triangles have then: beyond it there is nothing.
TEST(shadow_cover, nothing_is_proven_across_an_edge_of_three_triangles) {
  Surface surface;
  for (const auto& [x, y, z] :
       {std::array{-4.0, -2.0, 0.0}, std::array{-4.0, 2.0, 0.0}, std::array{0.0, -2.0, 0.0},
        std::array{0.0, 2.0, 0.0}, std::array{-1.0, 0.0, 0.01}, std::array{-1.0, 0.0, -0.01}})
    surface.positions.push_back(test::point(x, y, z));
  surface.triangles = {{0, 2, 3}, {0, 3, 1}, {2, 3, 4}, {2, 3, 5}};
  const Original original(surface);
  const Piece triangle{Vec3d{{-2, -0.5, 0}}, Vec3d{{3, 0, 0}}, Vec3d{{-2, 0.5, 0}}};
  for (std::uint32_t v = 0; v < 6; ++v) {
    EXPECT_EQ(original.bound(triangle, v, 0.5), kUnproven);
    for (const std::size_t cell : original.covered_cells(triangle, triangle, v, 0.5, 8))
      for (const Vec3d& corner : cell_of(triangle, cell, 8)) EXPECT_LE(corner[0], 0);
  }
}

TEST(shadow_cover, flat_triangles_are_left_to_others) {
  const Original patch(make_rough_patch(10, 0, 1));
  const Piece flat{Vec3d{{1, 1, 0}}, Vec3d{{3, 3, 0}}, Vec3d{{5, 5, 0}}};
  EXPECT_EQ(patch.bound(flat, patch.nearest({{3, 3, 0}}), 0.2), kUnproven);
  const Piece point{Vec3d{{1, 1, 0}}, Vec3d{{1, 1, 0}}, Vec3d{{1, 1, 0}}};
  EXPECT_EQ(patch.bound(point, patch.nearest({{1, 1, 0}}), 0.2), kUnproven);
}

}  // namespace
}  // namespace lode::simplification
