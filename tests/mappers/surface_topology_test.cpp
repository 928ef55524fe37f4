#include "lode/mappers/surface_topology.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "lode/mappers/surface_checks.h"
#include "tests/mappers/shape_surfaces.h"

namespace lode {
namespace {

using test::append;
using test::make_moebius_strip;
using test::make_sphere;
using test::make_torus;
using test::point;

TopologyReport report_of(const Surface& surface) {
  EXPECT_TRUE(check_well_formed(surface));
  return check_topology(surface, {.may_pinch = {}, .threads = {2}});
}

/// Two tetrahedra's surfaces; `shared` of their vertices are common.
Surface make_two_tetrahedra(std::uint32_t shared) {
  Surface surface;
  surface.positions = {point(0, 0, 0), point(0, 0, 1), point(1, 0, 0), point(1, 1, 0)};
  surface.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
  const std::uint32_t base = 4 - shared;
  for (std::uint32_t v = shared; v < 4; ++v) {
    const Vec3f& p = surface.positions[v];
    surface.positions.push_back({{-p[0] - 2, -p[1] - 2, p[2]}});
  }
  for (std::size_t i = 0; i < 4; ++i) {
    auto t = surface.triangles[i];
    for (std::uint32_t& v : t)
      if (v >= shared) v += base;
    surface.triangles.push_back(t);
  }
  return surface;
}

TEST(surface_topology, knows_spheres_and_tori) {
  const auto sphere = report_of(make_sphere(12, 1.0, {{0, 0, 0}}));
  EXPECT_TRUE(sphere.is_clean_manifold());
  EXPECT_TRUE(sphere.is_closed());
  EXPECT_EQ(sphere.euler_number, 2);
  EXPECT_EQ(sphere.components.size(), 1U);
  Surface both = make_torus(20, 10, 2.0, 0.5);
  append(both, make_sphere(8, 1.0, {{9, 0, 0}}));
  const auto report = report_of(both);
  EXPECT_TRUE(report.is_clean_manifold());
  ASSERT_EQ(report.components.size(), 2U);
  EXPECT_EQ(report.components[0].euler_number, 0);
  EXPECT_EQ(report.components[0].n_simplices, 400U);
  EXPECT_EQ(report.components[1].euler_number, 2);
  EXPECT_EQ(report.euler_number, 2);
  EXPECT_EQ(report.n_edges * 2, both.triangles.size() * 3);
}

TEST(surface_topology, sees_a_flipped_triangle) {
  Surface surface = make_sphere(6, 1.0, {{0, 0, 0}});
  std::swap(surface.triangles[20][0], surface.triangles[20][1]);
  const auto report = report_of(surface);
  EXPECT_EQ(report.inconsistent_edges.count, 3U);
  EXPECT_EQ(report.non_manifold_edges.count, 0U);
}

TEST(surface_topology, cannot_orient_a_moebius_strip) {
  const auto report = report_of(make_moebius_strip(24));
  EXPECT_EQ(report.non_manifold_vertices.count, 0U);
  EXPECT_EQ(report.inconsistent_edges.count, 1U);
  EXPECT_EQ(report.n_boundary_edges, 48U);
  EXPECT_EQ(report.euler_number, 0);
}

TEST(surface_topology, reports_a_missing_triangle_as_boundary) {
  Surface surface = make_sphere(6, 1.0, {{0, 0, 0}});
  const auto t = surface.triangles.back();
  surface.triangles.pop_back();
  const auto report = report_of(surface);
  EXPECT_TRUE(report.is_clean_manifold());
  EXPECT_EQ(report.n_boundary_edges, 3U);
  EXPECT_EQ(report.components[0].n_boundary_edges, 3U);
  EXPECT_EQ(report.euler_number, 1);
  // Each edge runs as its remaining triangle does, against the removed one.
  for (const auto& edge : find_boundary_edges(surface, {1})) {
    bool is_reversed = false;
    for (std::size_t k = 0; k < 3; ++k) is_reversed |= edge[0] == t[(k + 1) % 3] && edge[1] == t[k];
    EXPECT_TRUE(is_reversed);
  }
}

TEST(surface_topology, refuses_tetrahedra_that_share_a_vertex) {
  const auto report = report_of(make_two_tetrahedra(1));
  EXPECT_EQ(report.non_manifold_vertices.count, 1U);
  EXPECT_EQ(report.non_manifold_vertices.first[0], 0U);
  EXPECT_EQ(report.non_manifold_edges.count, 0U);
}

TEST(surface_topology, refuses_tetrahedra_that_share_an_edge) {
  const auto report = report_of(make_two_tetrahedra(2));
  EXPECT_EQ(report.non_manifold_edges.count, 1U);
  EXPECT_EQ(report.non_manifold_edges.first, (std::array<std::uint32_t, 2>{0, 1}));
  EXPECT_FALSE(report.is_clean_manifold());
}

TEST(surface_topology, counts_degenerate_triangles_and_unused_vertices) {
  Surface surface = make_sphere(6, 1.0, {{0, 0, 0}});
  const auto n = static_cast<std::uint32_t>(surface.positions.size());
  surface.positions.push_back(point(5, 0, 0));
  surface.positions.push_back(point(6, 1, 0));
  surface.positions.push_back(point(7, 2, 0));
  surface.triangles.push_back({0, 0, 1});
  auto report = report_of(surface);
  EXPECT_EQ(report.degenerate_simplices.count, 1U);
  EXPECT_EQ(report.isolated_vertices.count, 3U);
  EXPECT_EQ(report.isolated_vertices.first[0], n);
  EXPECT_EQ(report.euler_number, 2) << "a repeated vertex leaves the rest as it was";
  surface.triangles.push_back({n, n + 1, n + 2});
  report = report_of(surface);
  EXPECT_EQ(report.degenerate_simplices.count, 2U);
  EXPECT_EQ(report.isolated_vertices.count, 0U);
}

TEST(surface_topology, tells_twins_from_duplicates) {
  Surface surface;
  surface.positions = {point(0, 0, 0),    point(1, 0, 1),  point(0, 1, 1),
                       point(-0.0, 0, 0), point(1, 0, -1), point(0, 1, -1)};
  surface.triangles = {{0, 1, 2}, {3, 4, 5}};
  auto report = report_of(surface);
  EXPECT_EQ(report.n_twins, 1U);
  EXPECT_EQ(report.duplicate_vertices.count, 0U);
  report =
      check_topology(surface, {.may_pinch = [](std::uint32_t) { return false; }, .threads = {}});
  EXPECT_EQ(report.n_twins, 0U);
  EXPECT_EQ(report.duplicate_vertices.first, (std::array<std::uint32_t, 2>{0, 3}));
  // Closed surfaces have no boundary, so what coincides there is a duplicate.
  Surface touching = make_sphere(6, 1.0, {{0, 0, 0}});
  append(touching, make_sphere(6, 1.0, {{0, 0, 2}}));
  EXPECT_EQ(report_of(touching).duplicate_vertices.count, 1U);
}

TEST(surface_topology, follows_contour_lines) {
  Surface surface;
  for (int i = 0; i < 8; ++i) surface.positions.push_back(point(i, i % 3, 0));
  surface.lines = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}};
  auto report = report_of(surface);
  EXPECT_EQ(report.n_boundary_edges, 2U);
  EXPECT_EQ(report.isolated_vertices.count, 2U);
  ASSERT_EQ(report.components.size(), 2U);
  EXPECT_EQ(report.components[0].euler_number, 0);
  EXPECT_EQ(report.components[1].euler_number, 1);
  EXPECT_EQ(report.components[1].n_boundary_edges, 2U);
  EXPECT_EQ(find_boundary_edges(surface, {1}).size(), 2U);
  surface.lines.push_back({6, 1});
  surface.lines.push_back({7, 5});
  report = report_of(surface);
  EXPECT_EQ(report.non_manifold_vertices.first[0], 1U);
  EXPECT_EQ(report.inconsistent_edges.count, 1U);
  EXPECT_EQ(report.inconsistent_edges.first[0], 5U);
}

TEST(surface_topology, is_the_same_for_any_threads) {
  const Surface surface = make_torus(200, 100, 2.0, 0.5);
  EXPECT_EQ(check_topology(surface, {.may_pinch = {}, .threads = {1}}),
            check_topology(surface, {.may_pinch = {}, .threads = {4}}));
}

TEST(surface_checks, refuse_indices_out_of_range_and_coordinates_that_are_no_numbers) {
  Surface surface = make_sphere(6, 1.0, {{0, 0, 0}});
  surface.triangles[3][1] = 100000;
  EXPECT_FALSE(check_well_formed(surface));
  surface = make_sphere(6, 1.0, {{0, 0, 0}});
  surface.positions[2][1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(check_well_formed(surface));
  surface = make_sphere(6, 1.0, {{0, 0, 0}});
  surface.lines.push_back({0, 1});
  EXPECT_FALSE(check_well_formed(surface));
}

}  // namespace
}  // namespace lode
