#include "lode/mappers/simplify_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "lode/mappers/surface_checks.h"
#include "tests/mappers/distance_oracle.h"
#include "tests/mappers/shape_surfaces.h"

namespace lode {
namespace {

using test::append;
using test::make_sphere;
using test::make_torus;
using test::point;

using test::one_sided_distance;
using test::widen;

/// A sphere whose vertices lie up to half of `amount` off it: a star seen from its centre, which
/// does not meet itself.
Surface make_rough_sphere(double amount) {
  const Vec3d centre{{100, -50, 7}};
  Surface surface = make_sphere(24, 7, {{0, 0, 0}});
  std::mt19937 random(7);
  for (Vec3f& p : surface.positions) {
    const double scale = 1 + amount / 7 * (static_cast<double>(random()) / 4294967296.0 - 0.5);
    p = point(centre[0] + scale * double{p[0]}, centre[1] + scale * double{p[1]},
              centre[2] + scale * double{p[2]});
  }
  return surface;
}

/// A patch over [0, n]² whose border lies in four planes; up to `height` high.
Surface make_hills(std::uint32_t n, double height, unsigned seed) {
  std::mt19937 random(seed);
  return test::make_patch(n, [&](std::uint32_t x, std::uint32_t y) {
    return height * (std::sin(0.3 * x) * std::cos(0.2 * y) +
                     0.2 * (static_cast<double>(random()) / 4294967296.0));
  });
}

/// A closed plate: two sheets with this gap between them, bent.
Surface make_plate(std::uint32_t rings, double thickness) {
  Surface surface = make_sphere(rings, 1, {{0, 0, 0}});
  for (Vec3f& p : surface.positions) {
    const double x = 8 * double{p[0]};
    const double y = 8 * double{p[1]};
    p = point(x, y, thickness * 0.5 * double{p[2]} + 0.02 * x * x);
  }
  return surface;
}

struct Shape {
  std::string name;
  double max_distance;
  std::size_t at_most;  ///< Triangles that are left; more would mean that it hardly works.
  std::function<Surface()> make;
};

void PrintTo(const Shape& shape, std::ostream* out) { *out << shape.name; }

std::vector<Shape> shapes() {
  return {
      {"sphere", 0.5, 400,
       [] {
         return make_sphere(24, 7, {{100, -50, 7}});
       }},
      {"sphere_closely", 0.05, 3000,
       [] {
         return make_sphere(24, 7, {{100, -50, 7}});
       }},
      {"rough_sphere", 0.6, 1500, [] { return make_rough_sphere(0.6); }},
      {"rough_sphere_within_its_roughness", 0.1, 6000, [] { return make_rough_sphere(0.6); }},
      {"torus", 0.4, 700, [] { return make_torus(60, 24, 9, 3); }},
      {"thin_torus", 0.5, 900, [] { return make_torus(100, 8, 10, 0.4); }},
      {"hills", 0.5, 1500, [] { return make_hills(30, 2, 3); }},
      {"plain", 0.25, 120, [] { return make_hills(30, 0.1, 3); }},
      {"thin_plate", 1, 1800, [] { return make_plate(24, 0.5); }},
      {"plates_in_each_other", 1, 3600,
       [] {
         Surface surface = make_plate(24, 1.5);
         Surface inner = make_plate(24, 0.5);
         for (Vec3f& p : inner.positions) p = 0.8F * p;
         append(surface, inner);
         return surface;
       }},
      {"specks", 2, 12000,
       [] {
         Surface surface;
         for (int i = 0; i < 20; ++i)
           append(surface, make_sphere(4, 0.5, {{3.0 * (i % 7), 3.0 * (i / 7), 0.1 * i}}));
         return surface;
       }},
  };
}

Surface simplified(Surface surface, double max_distance, int threads, SimplifyReport& report) {
  Progress progress;
  const auto done =
      simplify_surface(surface, {.max_distance = max_distance, .threads = {threads}}, progress);
  EXPECT_TRUE(done);
  if (done) report = *done;
  return surface;
}

Surface simplified(const Surface& surface, double max_distance) {
  SimplifyReport report;
  return simplified(surface, max_distance, 2, report);
}

class SimplifyShape : public testing::TestWithParam<Shape> {};

INSTANTIATE_TEST_SUITE_P(all, SimplifyShape, testing::ValuesIn(shapes()),
                         [](const auto& shape) { return shape.param.name; });

TEST_P(SimplifyShape, stays_within_the_distance_both_ways) {
  const Surface surface = GetParam().make();
  SimplifyReport report;
  const Surface simple = simplified(surface, GetParam().max_distance, 2, report);
  EXPECT_LE(report.proven_distance, GetParam().max_distance);
  // The proof is about real numbers, the oracle rounds: to a few 1e-16 of coordinates up to 120.
  const double proven = report.proven_distance + 1e-12;
  EXPECT_LE(one_sided_distance(surface, simple, 2), proven);
  EXPECT_LE(one_sided_distance(simple, surface, 6), proven);
}

TEST_P(SimplifyShape, leaves_few_triangles) {
  const Surface surface = GetParam().make();
  SimplifyReport report;
  const Surface simple = simplified(surface, GetParam().max_distance, 2, report);
  EXPECT_LE(simple.triangles.size(), GetParam().at_most);
  EXPECT_EQ(report.triangles_before, surface.triangles.size());
  EXPECT_EQ(report.triangles, simple.triangles.size());
  EXPECT_EQ(report.collapses, surface.positions.size() - simple.positions.size());
}

TEST_P(SimplifyShape, keeps_a_manifold_of_the_same_kind) {
  const Surface surface = GetParam().make();
  const Surface simple = simplified(surface, GetParam().max_distance);
  ASSERT_TRUE(check_well_formed(simple));
  const TopologyReport before = check_topology(surface, {});
  const TopologyReport after = check_topology(simple, {});
  EXPECT_TRUE(after.is_clean_manifold());
  ASSERT_EQ(after.components.size(), before.components.size());
  EXPECT_EQ(after.euler_number, before.euler_number);
  EXPECT_EQ(after.n_boundary_edges == 0, before.n_boundary_edges == 0);
}

TEST_P(SimplifyShape, does_not_meet_itself) {
  Progress progress;
  const Surface surface = GetParam().make();
  const auto before = check_self_intersections(surface, {2}, progress);
  ASSERT_TRUE(before);
  ASSERT_EQ(before->n_intersections, 0U);
  const Surface simple = simplified(surface, GetParam().max_distance);
  const auto report = check_self_intersections(simple, {2}, progress);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->n_intersections, 0U);
}

TEST_P(SimplifyShape, is_the_same_for_any_number_of_threads) {
  const Surface surface = GetParam().make();
  SimplifyReport one;
  const Surface simple = simplified(surface, GetParam().max_distance, 1, one);
  for (const int threads : {2, 5}) {
    SimplifyReport many;
    const Surface again = simplified(surface, GetParam().max_distance, threads, many);
    EXPECT_EQ(again.positions, simple.positions);
    EXPECT_EQ(again.triangles, simple.triangles);
    EXPECT_EQ(many.undone, one.undone);
    EXPECT_EQ(many.proven_distance, one.proven_distance);
  }
}

/// The border edges that lie in the plane where coordinate i is x, as a length.
double border_length(const Surface& surface, std::size_t i, float x) {
  double sum = 0;
  for (const auto& [a, b] : find_boundary_edges(surface, {}))
    if (surface.positions[a][i] == x && surface.positions[b][i] == x)
      sum += length(widen(surface.positions[a]) - widen(surface.positions[b]));
  return sum;
}

TEST(simplify_surface, is_the_same_in_any_unit) {
  const Surface surface = make_rough_sphere(0.6);
  const Surface expected = simplified(surface, 0.6);
  EXPECT_LT(expected.triangles.size(), surface.triangles.size() / 2);
  for (const int exponent : {-60, -30, -13, 13, 30, 60}) {
    Surface scaled = surface;
    for (Vec3f& p : scaled.positions)
      for (float& x : p.v) x = std::ldexp(x, exponent);
    const Surface result = simplified(scaled, std::ldexp(0.6, exponent));
    EXPECT_EQ(result.triangles, expected.triangles);
    ASSERT_EQ(result.positions.size(), expected.positions.size());
    for (std::size_t v = 0; v < result.positions.size(); ++v)
      for (std::size_t i = 0; i < 3; ++i)
        ASSERT_EQ(result.positions[v][i], std::ldexp(expected.positions[v][i], exponent));
  }
}

TEST(simplify_surface, keeps_the_border_in_its_planes) {
  const Surface surface = make_hills(50, 0.1, 3);
  const Surface simple = simplified(surface, 0.25);
  const std::size_t n = find_boundary_edges(simple, {}).size();
  EXPECT_LT(n, 60U);  // of 200
  double sum = 0;
  for (const std::size_t i : {0U, 1U})
    for (const float x : {0.0F, 50.0F}) sum += border_length(simple, i, x);
  double all = 0;
  for (const auto& [a, b] : find_boundary_edges(simple, {}))
    all += length(widen(simple.positions[a]) - widen(simple.positions[b]));
  EXPECT_DOUBLE_EQ(sum, all);
  EXPECT_GE(sum, 200 - 1e-9);
}

TEST(simplify_surface, leaves_an_oblique_border_alone) {
  Surface surface = make_hills(20, 0.1, 3);
  for (Vec3f& p : surface.positions)
    p = point(0.8 * double{p[0]} - 0.6 * double{p[1]}, 0.6 * double{p[0]} + 0.8 * double{p[1]},
              0.3 * double{p[0]} + double{p[2]});
  const Surface simple = simplified(surface, 0.25);
  EXPECT_EQ(find_boundary_edges(simple, {}).size(), 80U);
  EXPECT_LT(simple.triangles.size(), 600U);  // of 800
}

/// A ball just inside a box, which is turned and whose edges have other units than positions.
TEST(simplify_surface, does_not_leave_its_domain) {
  constexpr double kRadius = 7;
  constexpr double kBeyond = 0.05;
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  ConvexDomain domain{{{{{3 * c, 3 * s, 0}}, {{-s, c, 0}}, {{0, 0, 0.2}}}}, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) {
    domain.at[i] = (kRadius + kBeyond) * length(domain.along[i]);
    domain.most[i] = 2 * domain.at[i];
  }
  const auto outside_of = [&](const SimplifyOptions& options) {
    Surface surface = make_sphere(24, kRadius, {{0, 0, 0}});
    Progress progress;
    const auto report = simplify_surface(surface, options, progress);
    EXPECT_TRUE(report);
    EXPECT_LT(surface.triangles.size(), 400U);
    return std::ranges::count_if(surface.positions, [&](const Vec3f& p) {
      return !domain.has({{p[0], p[1], p[2]}});
    });
  };
  EXPECT_GT(outside_of({.max_distance = 1}), 0);
  EXPECT_EQ(outside_of({.max_distance = 1, .domain = &domain}), 0);
}

TEST(simplify_surface, keeps_what_meets_itself_already) {
  Surface surface = make_sphere(20, 5, {{0, 0, 0}});
  append(surface, make_sphere(20, 5, {{3, 0.1, 0.2}}));
  SimplifyReport report;
  const Surface simple = simplified(surface, 0.3, 2, report);
  Progress progress;
  const auto crossings = check_self_intersections(simple, {}, progress);
  ASSERT_TRUE(crossings);
  EXPECT_GT(report.input_crossings, 0U);
  EXPECT_EQ(crossings->n_intersections, report.input_crossings);
  EXPECT_LT(simple.triangles.size(), surface.triangles.size());
}

TEST(simplify_surface, takes_attributes_along) {
  Surface surface = make_sphere(40, 12, {{0, 0, 0}});
  for (const Vec3f& p : surface.positions) {
    surface.normals.push_back(normalized(p));
    surface.isovalues.push_back(p[0] > 100 ? 1.0F : 2.0F);
  }
  const Surface simple = simplified(surface, 0.4);
  ASSERT_EQ(simple.normals.size(), simple.positions.size());
  ASSERT_EQ(simple.isovalues.size(), simple.positions.size());
  for (std::size_t v = 0; v < simple.normals.size(); ++v) {
    EXPECT_NEAR(length(simple.normals[v]), 1, 1e-5);
    EXPECT_GT(dot(simple.normals[v], normalized(simple.positions[v])), 0.95F);
    EXPECT_EQ(simple.isovalues[v], 2.0F);
  }
}

TEST(simplify_surface, drops_no_vertex_that_no_triangle_has) {
  Surface surface = make_sphere(24, 7, {{0, 0, 0}});
  surface.positions.push_back(point(1, 2, 3));
  SimplifyReport report;
  const Surface simple = simplified(surface, 0.5, 2, report);
  EXPECT_LT(simple.triangles.size(), 400U);
  EXPECT_EQ(simple.positions.back(), point(1, 2, 3));
}

TEST(simplify_surface, does_nothing_to_nothing) {
  SimplifyReport report;
  EXPECT_TRUE(simplified(Surface(), 1, 2, report).is_empty());
  EXPECT_EQ(report.triangles, 0U);
}

TEST(simplify_surface, leaves_the_surface_alone_when_cancelled) {
  Surface surface = make_sphere(40, 12, {{0, 0, 0}});
  const Surface before = surface;
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(simplify_surface(surface, {.max_distance = 1}, progress));
  EXPECT_EQ(surface.positions, before.positions);
  EXPECT_EQ(surface.triangles, before.triangles);
}

}  // namespace
}  // namespace lode
