#include "lode/mappers/self_intersections.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>

#include "lode/mappers/surface_checks.h"
#include "tests/mappers/shape_surfaces.h"

namespace lode {
namespace {

using test::append;
using test::make_sphere;
using test::make_torus;
using test::point;

SelfIntersectionReport intersections_of(const Surface& surface, int threads = 2) {
  Progress progress;
  EXPECT_TRUE(check_well_formed(surface));
  auto report = check_self_intersections(surface, {threads}, progress);
  EXPECT_TRUE(report);
  return *report;
}

std::uint64_t n_intersections(const Surface& surface) {
  return intersections_of(surface).n_intersections;
}

TEST(self_intersections, are_not_seen_in_spheres_and_tori) {
  EXPECT_EQ(n_intersections(make_sphere(40, 1.0, {{0, 0, 0}})), 0U);
  EXPECT_EQ(n_intersections(make_torus(60, 30, 2.0, 0.7)), 0U);
  EXPECT_EQ(n_intersections({}), 0U);
}

TEST(self_intersections, are_found_where_a_torus_overlaps_itself) {
  EXPECT_GT(n_intersections(make_torus(60, 30, 0.5, 0.7)), 0U);
}

TEST(self_intersections, are_found_between_interpenetrating_spheres_only) {
  Surface apart = make_sphere(20, 1.0, {{0, 0, 0}});
  append(apart, make_sphere(20, 1.0, {{2.5, 0, 0}}));
  EXPECT_EQ(n_intersections(apart), 0U);
  Surface nested = make_sphere(20, 1.0, {{0, 0, 0}});
  append(nested, make_sphere(20, 0.9, {{0, 0, 0}}));
  EXPECT_EQ(n_intersections(nested), 0U);
  Surface crossing = make_sphere(20, 1.0, {{0, 0, 0}});
  const auto n_first = static_cast<std::uint32_t>(crossing.triangles.size());
  append(crossing, make_sphere(20, 1.0, {{1.03, 0.01, 0.02}}));
  const auto report = intersections_of(crossing);
  EXPECT_GT(report.n_intersections, 20U);
  EXPECT_LT(report.first[0], n_first);
  EXPECT_GE(report.first[1], n_first);
}

TEST(self_intersections, survive_a_large_offset) {
  // At 1e5 float32 steps are 0.008: the sphere of radius 50 keeps its shape.
  EXPECT_EQ(n_intersections(make_sphere(10, 50.0, {{1e5, -1e5, 1e5}})), 0U);
}

TEST(self_intersections, are_the_same_for_any_threads) {
  Surface crossing = make_sphere(30, 1.0, {{0, 0, 0}});
  append(crossing, make_sphere(30, 1.0, {{0.5, 0.1, 0.2}}));
  EXPECT_EQ(intersections_of(crossing, 1), intersections_of(crossing, 4));
}

TEST(self_intersections, include_coplanar_overlaps) {
  Surface surface;
  surface.positions = {point(0, 0, 0), point(4, 0, 0), point(0, 4, 0),
                       point(1, 1, 0), point(2, 1, 0), point(1, 2, 0)};
  surface.triangles = {{0, 1, 2}, {3, 4, 5}};
  EXPECT_EQ(n_intersections(surface), 1U);
  surface.triangles = {{0, 1, 2}, {0, 1, 2}};
  EXPECT_EQ(n_intersections(surface), 1U);
  // Folded over a common edge; then over a common corner.
  surface.triangles = {{0, 1, 2}, {0, 1, 3}};
  EXPECT_EQ(n_intersections(surface), 1U);
  surface.triangles = {{0, 1, 2}, {0, 3, 4}};
  EXPECT_EQ(n_intersections(surface), 1U);
}

TEST(self_intersections, allow_twins_to_touch_but_not_to_cross) {
  Surface surface;
  surface.positions = {point(0, 0, 0), point(1, 0, 1),  point(0, 1, 1),
                       point(0, 0, 0), point(1, 0, -1), point(0, 1, -1)};
  surface.triangles = {{0, 1, 2}, {3, 4, 5}};
  EXPECT_EQ(n_intersections(surface), 0U);
  surface.positions[4] = point(0.4, 0.4, 0.2);
  surface.positions[5] = point(0.4, 0.4, 4);
  EXPECT_EQ(n_intersections(surface), 1U);
}

TEST(self_intersections, include_a_corner_that_touches_a_face) {
  Surface surface;
  surface.positions = {point(0, 0, 0), point(4, 0, 0), point(0, 4, 0),
                       point(1, 1, 0), point(1, 1, 1), point(2, 1, 1)};
  surface.triangles = {{0, 1, 2}, {3, 4, 5}};
  EXPECT_EQ(n_intersections(surface), 1U);
}

TEST(self_intersections, leave_out_triangles_of_no_area) {
  Surface surface = make_sphere(6, 1.0, {{0, 0, 0}});
  surface.triangles.push_back({0, 1, 1});
  const auto report = intersections_of(surface);
  EXPECT_EQ(report.n_simplices + 1, surface.triangles.size());
  EXPECT_EQ(report.n_intersections, 0U);
}

TEST(self_intersections, are_found_in_contour_lines_of_any_plane) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Surface surface;
    constexpr std::array<std::array<int, 2>, 5> kPoints = {
        {{0, 0}, {2, 2}, {0, 2}, {2, 0}, {4, 0}}};
    for (const auto& [u, v] : kPoints) {
      Vec3f p{{7, 7, 7}};
      p[(axis + 1) % 3] = static_cast<float>(u);
      p[(axis + 2) % 3] = static_cast<float>(v);
      surface.positions.push_back(p);
    }
    surface.lines = {{0, 2}, {2, 1}, {1, 3}};
    EXPECT_EQ(n_intersections(surface), 0U);
    surface.lines = {{0, 1}, {1, 2}, {2, 3}};
    EXPECT_EQ(n_intersections(surface), 1U);
    surface.lines = {{0, 4}, {4, 3}};
    EXPECT_EQ(n_intersections(surface), 1U) << "doubling back on itself";
  }
}

TEST(self_intersections, stop_when_cancelled) {
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(check_self_intersections(make_sphere(6, 1.0, {{0, 0, 0}}), {1}, progress));
}

}  // namespace
}  // namespace lode
