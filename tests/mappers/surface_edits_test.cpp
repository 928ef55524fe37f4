#include "lode/mappers/surface_edits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "lode/mappers/surface_topology.h"
#include "tests/mappers/shape_surfaces.h"
#include "tests/oracles/random.h"

namespace lode {
namespace {

using test::point;

/// Three pairs of triangles that share an edge, all round vertex 0; the pairs take turns.
Surface make_three_fans() {
  Surface surface;
  for (int i = 0; i < 10; ++i) surface.positions.push_back(point(i, i * i, 0));
  surface.isovalues.resize(10);
  std::iota(surface.isovalues.begin(), surface.isovalues.end(), 0.0F);
  surface.origins = surface.positions;
  surface.triangles = {{1, 2, 0}, {0, 4, 5}, {8, 0, 7}, {0, 2, 3}, {5, 6, 0}, {9, 0, 8}};
  return surface;
}

TEST(surface_edits, gives_each_fan_its_own_vertex) {
  Surface surface = make_three_fans();
  split_pinched_vertices(surface);
  const std::vector<std::array<std::uint32_t, 3>> expected = {
      {{1, 2, 0}}, {{10, 4, 5}}, {{8, 11, 7}}, {{0, 2, 3}}, {{5, 6, 10}}, {{9, 11, 8}}};
  EXPECT_EQ(surface.triangles, expected);
  ASSERT_EQ(surface.positions.size(), 12U);
  EXPECT_EQ(surface.positions[10], surface.positions[0]);
  EXPECT_EQ(surface.positions[11], surface.positions[0]);
  ASSERT_EQ(surface.isovalues.size(), 12U);
  EXPECT_EQ(surface.isovalues[10], surface.isovalues[0]);
  EXPECT_EQ(surface.origins, surface.positions);
}

TEST(surface_edits, leaves_manifolds_alone) {
  for (Surface surface :
       {test::make_sphere(7, 1.0, {{0, 0, 0}}), test::make_torus(9, 5, 2.0, 0.5)}) {
    const auto before = surface.triangles;
    split_pinched_vertices(surface);
    EXPECT_EQ(surface.triangles, before);
  }
}

/// A sheet of 2 (n-1)^2 triangles; its vertices lie at most `n_beside` float32 steps beside
/// multiples of a half, its diagonals run at random, and triangles start with any corner.
Surface make_sheet(int n, int n_beside, oracles::Random& random, bool is_flat) {
  Surface surface;
  const auto nudged = [&](double x) {
    auto y = static_cast<float>(x);
    const auto n_steps =
        static_cast<int>(random.below(static_cast<std::uint64_t>(2 * n_beside + 1))) - n_beside;
    for (int i = 0; i < std::abs(n_steps); ++i)
      y = std::nextafter(y, n_steps < 0 ? -100.0F : 100.0F);
    return y;
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const float z = is_flat ? 0.7F : nudged(0.5 * static_cast<double>(random.below(3)));
      surface.positions.push_back({{nudged(0.5 * i), nudged(0.5 * j), z}});
    }
  const auto m = static_cast<std::uint32_t>(n);
  for (std::uint32_t i = 0; i + 1 < m; ++i)
    for (std::uint32_t j = 0; j + 1 < m; ++j) {
      const std::uint32_t p = i * m + j;
      const bool is_turned = random.below(2) == 0;
      const std::uint32_t apex = is_turned ? p + m + 1 : p + m;
      surface.triangles.push_back({p, apex, p + 1});
      if (is_turned)
        surface.triangles.push_back({p, p + m, apex});
      else
        surface.triangles.push_back({p + 1, apex, p + m + 1});
    }
  for (auto& t : surface.triangles)
    std::rotate(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(random.below(3)), t.end());
  return surface;
}

TEST(surface_edits, cuts_beside_vertices_leave_no_degenerate_triangle) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    oracles::Random random(seed);
    constexpr std::array kBeside{1, 5, 40};
    Surface surface = make_sheet(12, kBeside[seed % 3], random, seed % 2 == 0);
    ASSERT_TRUE(check_topology(surface, {}).is_clean_manifold());
    crop(surface, {{{1.0, 1.5, 0.5}}, {{4.0, 3.5, 1.0}}});
    split_pinched_vertices(surface);
    const TopologyReport report = check_topology(surface, {});
    EXPECT_GT(report.n_simplices, 0U);
    EXPECT_TRUE(report.is_clean_manifold())
        << "seed " << seed << ": " << report.degenerate_simplices.count << " degenerate, "
        << report.duplicate_vertices.count << " duplicate, " << report.non_manifold_edges.count
        << " edges";
  }
}

TEST(surface_edits, what_lies_in_a_plane_of_the_box_is_inside) {
  oracles::Random random(1);
  for (const Box3d& box :
       {Box3d{{{-9, -9, -9}}, {{9, 9, 0.7}}}, Box3d{{{-9, -9, 0.7}}, {{9, 9, 9}}}}) {
    Surface surface = make_sheet(5, 0, random, true);
    const auto before = surface.triangles;
    crop(surface, box);
    EXPECT_EQ(surface.triangles, before);
  }
}

/// Values stay linear, and errors, regions and patches those of the triangle a part is of.
TEST(surface_edits, keep_what_cells_and_vertices_have) {
  Surface surface = test::make_torus(30, 20, 2.0, 0.7);
  const auto value_at = [](const Vec3f& p) {
    return 3.0 * static_cast<double>(p[0]) - static_cast<double>(p[1]) + 0.5;
  };
  surface.attributes.push_back({.name = "more", .error = 1});
  for (const Vec3f& p : surface.positions) {
    surface.values.push_back(value_at(p));
    surface.attributes[0].values.push_back(-value_at(p));
  }
  // Of which side of a plane the triangle's first corner is: told from where its parts lie.
  for (std::uint32_t i = 0; i < surface.triangles.size(); ++i) {
    surface.errors.push_back(static_cast<float>(i));
    surface.regions.push_back(1000 + i);
    surface.patch_marks.push_back(i % 2);
    surface.attributes[0].errors.push_back(static_cast<float>(2 * i));
  }
  const Surface before = surface;
  crop(surface, {{{-1.3, -2.2, -0.4}}, {{2.1, 1.7, 0.6}}});
  (void)drop_small_components(surface, 5);
  ASSERT_GT(surface.triangles.size(), 100U);
  ASSERT_EQ(surface.errors.size(), surface.triangles.size());
  ASSERT_EQ(surface.attributes[0].values.size(), surface.positions.size());
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    EXPECT_NEAR(surface.values[v], value_at(surface.positions[v]), 1e-5);
    EXPECT_NEAR(surface.attributes[0].values[v], -value_at(surface.positions[v]), 1e-5);
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto source = static_cast<std::uint32_t>(surface.errors[t]);
    EXPECT_EQ(surface.regions[t], 1000 + source);
    EXPECT_EQ(surface.patch_marks[t], source % 2);
    EXPECT_EQ(surface.attributes[0].errors[t], static_cast<float>(2 * source));
    const auto& of = before.triangles[source];
    const Vec3f normal = cross(before.positions[of[1]] - before.positions[of[0]],
                               before.positions[of[2]] - before.positions[of[0]]);
    for (const std::uint32_t v : surface.triangles[t])
      EXPECT_NEAR(dot(surface.positions[v] - before.positions[of[0]], normalized(normal)), 0, 1e-5);
  }
}

TEST(surface_edits, drops_pieces_below_a_size_and_counts_them) {
  Surface surface = test::make_torus(9, 5, 2.0, 0.5);
  const auto torus = surface.triangles;
  const std::size_t n_vertices = surface.positions.size();
  test::append(surface, test::make_sphere(3, 0.1, {{5, 0, 0}}));
  test::append(surface, test::make_sphere(3, 0.1, {{7, 0, 0}}));
  const auto all = surface.triangles;
  const std::size_t n_of_sphere = (all.size() - torus.size()) / 2;
  EXPECT_EQ(drop_small_components(surface, n_of_sphere).components, 0U);
  EXPECT_EQ(surface.triangles, all);
  const Dropped dropped = drop_small_components(surface, n_of_sphere + 1);
  EXPECT_EQ(dropped.components, 2U);
  EXPECT_EQ(dropped.cells, 2 * n_of_sphere);
  EXPECT_EQ(surface.triangles, torus);
  EXPECT_EQ(surface.positions.size(), n_vertices);
}

TEST(surface_edits, flipping_turns_triangles_and_normals) {
  Surface surface = test::make_sphere(5, 1.0, {{0, 0, 0}});
  surface.normals = surface.positions;
  const Surface before = surface;
  flip_orientation(surface);
  for (std::size_t v = 0; v < surface.normals.size(); ++v)
    EXPECT_EQ(surface.normals[v], before.normals[v] * -1.0F);
  EXPECT_NE(surface.triangles, before.triangles);
  flip_orientation(surface);
  EXPECT_EQ(surface.triangles, before.triangles);
  EXPECT_EQ(surface.normals, before.normals);
}

}  // namespace
}  // namespace lode
