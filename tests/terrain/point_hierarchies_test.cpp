// Hierarchies of triangulations of scattered points, and of rasters with breaklines, held against
// the points by trying all: the reference is the triangulation of all points.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/lined_hierarchy.h"
#include "lode/api/point_hierarchy.h"
#include "lode/delaunay/tin_links.h"
#include "lode/mappers/tin_lines.h"
#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/models/terrain/triangle_hierarchy/locator.h"
#include "lode/models/terrain/triangle_hierarchy/variable.h"
#include "lode/refine/focus.h"
#include "tests/terrain/hierarchy_fixtures.h"
#include "tests/terrain/point_terrains.h"

namespace lode::test {
namespace {

using delaunay::Tin;
using triangle_hierarchy::Place;
using triangle_hierarchy::PointSurface;
using Corners = std::array<std::uint32_t, 3>;

const std::vector<double> kPointLevels{1000, 30, 10, 1.5, 0.5};

enum class PointModel : std::uint8_t { adaptive, delaunay };

struct PointHierarchy {
  std::unique_ptr<const PointSurface> surface;
  Hierarchy hierarchy;
};

PointHierarchy build_of(const PointTerrain& terrain, PointModel model, Threads threads = {2},
                        const std::vector<double>& levels = kPointLevels) {
  Progress progress;
  auto surface = surface_of(terrain, progress);
  EXPECT_TRUE(surface) << surface.error().message;
  const auto first = first_mesh(terrain, **surface, levels.front(), progress);
  EXPECT_TRUE(first) << first.error().message;
  PointHierarchy made{std::move(surface).value(), {}};
  if (model == PointModel::adaptive) {
    auto built = adaptive_triangulation::build(*made.surface, levels, threads, progress, &*first);
    EXPECT_TRUE(built) << built.error().message;
    made.hierarchy = std::move(built->hierarchy);
  } else {
    auto built = hierarchical_delaunay::build(*made.surface, levels, threads, progress, &*first);
    EXPECT_TRUE(built) << built.error().message;
    made.hierarchy = std::move(built->hierarchy);
  }
  return made;
}

/// The height of a TIN's triangle above a place, if it holds that; exact but for the last steps.
std::optional<long double> height_of(const std::array<LatticePoint, 3>& at,
                                     const std::array<double, 3>& z, LatticePoint p) {
  long double sum = 0;
  std::int64_t area = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int64_t weight = delaunay::doubled_area(p, at[(i + 1) % 3], at[(i + 2) % 3]);
    if (weight < 0) return {};
    area += weight;
    sum += static_cast<long double>(weight) * static_cast<long double>(z[i]);
  }
  return sum / static_cast<long double>(area);
}

std::optional<long double> height_of(const Tin& tin, std::size_t t, LatticePoint p,
                                     std::int32_t scale) {
  std::array<LatticePoint, 3> at;
  std::array<double, 3> z{};
  for (std::size_t i = 0; i < 3; ++i) {
    const LatticePoint v = tin.vertices[tin.triangles[t][i]];
    at[i] = {v.x * scale, v.y * scale};
    z[i] = tin.heights[tin.triangles[t][i]];
  }
  return height_of(at, z, p);
}

double rounding_of(const PointTerrain& terrain) {
  const HeightRange range = height_range(terrain.points);
  return 0x1p-48 * std::max(std::abs(range.lower), std::abs(range.upper));
}

/// Each point of the domain is in a triangle, and errs by no more than the tolerance, and than the
/// triangle says, in all that hold it.
void expect_points_within(const Tin& tin, std::int32_t scale, const PointTerrain& terrain,
                          double tolerance) {
  const double rounding = rounding_of(terrain);
  const auto& points = terrain.points;
  for (std::size_t i = 0; i < points.nodes.size(); ++i) {
    const LatticePoint p{points.nodes[i].x * scale, points.nodes[i].y * scale};
    bool is_held = false;
    for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
      const auto height = height_of(tin, t, p, 1);
      if (!height) continue;
      is_held = true;
      const auto error = static_cast<double>(std::abs(*height - points.heights[i]));
      EXPECT_LE(error, tolerance + rounding) << p.x << ", " << p.y;
      if (!tin.errors.empty()) EXPECT_LE(error, static_cast<double>(tin.errors[t]));
    }
    EXPECT_EQ(is_held, terrain.domain.triangle_of[i] != delaunay::kNoHalfEdge);
  }
}

/// By trying all triangles.
void expect_on_surface(const PointHierarchy& made, const PointTerrain& terrain) {
  const Hierarchy& h = made.hierarchy;
  const Tin& all = made.surface->tin();
  for (std::size_t v = 0; v < h.vertices.size(); ++v) {
    bool is_held = false;
    for (std::size_t t = 0; t < all.triangles.size() && !is_held; ++t) {
      const auto height = height_of(all, t, h.vertices[v], h.scale());
      if (!height) continue;
      is_held = true;
      EXPECT_LE(std::abs(static_cast<double>(*height - h.heights[v])), rounding_of(terrain));
    }
    EXPECT_TRUE(is_held) << h.vertices[v].x << ", " << h.vertices[v].y;
  }
}

class point_hierarchies : public testing::TestWithParam<PointModel> {};

TEST_P(point_hierarchies, have_meshes_that_match_and_keep_their_tolerances) {
  for (const PointCase& c : point_cases()) {
    const PointHierarchy made = build_of(c.terrain, GetParam());
    const Hierarchy& h = made.hierarchy;
    ASSERT_EQ(h.n_levels(), static_cast<int>(kPointLevels.size()));
    EXPECT_TRUE(h.is_of_points);
    for (int level = 0; level < h.n_levels(); ++level) {
      SCOPED_TRACE(testing::Message() << c.name << ", level " << level);
      const Tin tin = tin_of_level(h, level, delaunay::TinLinks::kept);
      expect_fills_domain(tin, h.scale(), c.terrain);
      expect_points_within(tin, h.scale(), c.terrain,
                           kPointLevels[static_cast<std::size_t>(level)]);
    }
  }
}

TEST_P(point_hierarchies, are_hierarchies_with_vertices_on_the_triangulation_of_all_points) {
  for (const PointCase& c : point_cases()) {
    SCOPED_TRACE(c.name);
    const PointHierarchy made = build_of(c.terrain, GetParam());
    expect_hierarchy(made.hierarchy);
    EXPECT_EQ(n_out_of_reach(made.hierarchy), 0U);
    expect_on_surface(made, c.terrain);
  }
}

TEST_P(point_hierarchies, have_lines_as_edges_of_all_levels) {
  for (const PointCase& c : point_cases()) {
    SCOPED_TRACE(c.name);
    const Hierarchy h = build_of(c.terrain, GetParam()).hierarchy;
    ASSERT_EQ(h.lines.size(), c.terrain.domain.lines.size());
    std::vector<std::array<LatticePoint, 2>> lines;
    const auto fine = [&](std::uint32_t point) {
      const LatticePoint p = c.terrain.points.nodes[point];
      return LatticePoint{p.x * h.scale(), p.y * h.scale()};
    };
    for (const auto& [a, b] : c.terrain.domain.lines) lines.push_back({fine(a), fine(b)});
    for (int level = 0; level < h.n_levels(); ++level) {
      const Tin tin = tin_of_level(h, level, delaunay::TinLinks::left_out);
      EXPECT_EQ(TinLines(tin.triangles, tin.vertices, lines).n_broken(), 0U) << "level " << level;
    }
  }
}

TEST_P(point_hierarchies, are_the_same_for_any_number_of_threads) {
  for (const PointCase& c : point_cases()) {
    SCOPED_TRACE(c.name);
    const Hierarchy one = build_of(c.terrain, GetParam(), {1}).hierarchy;
    for (const int n : {2, 3, 4}) {
      const Hierarchy other = build_of(c.terrain, GetParam(), {n}).hierarchy;
      EXPECT_EQ(one.vertices, other.vertices);
      EXPECT_EQ(one.heights, other.heights);
      EXPECT_EQ(one.reach, other.reach);
      ASSERT_EQ(one.triangles.size(), other.triangles.size());
      for (std::size_t t = 0; t < one.triangles.size(); ++t) {
        EXPECT_EQ(one.triangles[t].corner, other.triangles[t].corner);
        EXPECT_EQ(one.triangles[t].twin, other.triangles[t].twin);
        EXPECT_EQ(one.triangles[t].error, other.triangles[t].error);
      }
    }
  }
}

PointTerrain terrain_of(const std::vector<Vec3d>& points, const PointTerrainOptions& options = {}) {
  Progress progress;
  auto made = make_point_terrain(points, {{0, 0}, 1}, {}, options, progress);
  EXPECT_TRUE(made) << made.error().message;
  return *std::move(made);
}

/// All cells are squares, so every four points of one lie on a circle.
TEST_P(point_hierarchies, take_points_of_a_grid) {
  std::vector<Vec3d> points;
  for (int y = 0; y < 14; ++y)
    for (int x = 0; x < 17; ++x)
      points.push_back({{10.0 * x, 10.0 * y, std::round(rough_hills(4 * x, 4 * y))}});
  const PointTerrain terrain = terrain_of(points);
  const PointHierarchy made = build_of(terrain, GetParam());
  for (int level = 0; level < made.hierarchy.n_levels(); ++level) {
    const Tin tin = tin_of_level(made.hierarchy, level, delaunay::TinLinks::kept);
    expect_fills_domain(tin, made.hierarchy.scale(), terrain);
    expect_points_within(tin, made.hierarchy.scale(), terrain,
                         kPointLevels[static_cast<std::size_t>(level)]);
  }
  expect_on_surface(made, terrain);
}

TEST_P(point_hierarchies, refine_no_planes) {
  std::vector<Vec3d> points;
  for (const LatticePoint& p : delaunay::test::random_nodes(300, 5000, 8))
    points.push_back(
        {{static_cast<double>(p.x), static_cast<double>(p.y), 1234.56 + 0.1 * p.x - 0.7 * p.y}});
  const Hierarchy h = build_of(terrain_of(points), GetParam()).hierarchy;
  EXPECT_EQ(h.refinements.size(), 0U);
}

/// Where the lattice of the points has all 30 bits there is none finer, and crossings go to its own
/// nodes; clusters beside far points.
TEST_P(point_hierarchies, take_points_of_the_largest_lattice_and_in_clusters) {
  std::vector<Vec3d> points{{{0, 0, 3}},
                            {{(1 << 30) - 1.0, 0, 90}},
                            {{0, (1 << 30) - 1.0, 40}},
                            {{(1 << 30) - 1.0, (1 << 30) - 1.0, 5}}};
  oracles::Random random(12);
  for (int cluster = 0; cluster < 4; ++cluster) {
    const double x = std::round(random.uniform(1e8, 9e8));
    const double y = std::round(random.uniform(1e8, 9e8));
    const double size = cluster % 2 == 0 ? 20 : 1e5;
    for (int i = 0; i < 25; ++i)
      points.push_back({{x + std::round(random.uniform(0, size)),
                         y + std::round(random.uniform(0, size)), random.uniform(0, 12)}});
  }
  const PointTerrain terrain = terrain_of(points);
  ASSERT_EQ(terrain.points.n_columns, 1 << 30);
  const PointHierarchy made = build_of(terrain, GetParam());
  EXPECT_EQ(made.hierarchy.bits, 0);
  for (int level = 0; level < made.hierarchy.n_levels(); ++level) {
    const Tin tin = tin_of_level(made.hierarchy, level, delaunay::TinLinks::kept);
    expect_fills_domain(tin, 1, terrain);
    expect_points_within(tin, 1, terrain, kPointLevels[static_cast<std::size_t>(level)]);
  }
  expect_on_surface(made, terrain);
}

TEST_P(point_hierarchies, find_the_triangles_of_places_by_descent) {
  for (const PointCase& c : point_cases()) {
    SCOPED_TRACE(c.name);
    const Hierarchy h = build_of(c.terrain, GetParam()).hierarchy;
    const triangle_hierarchy::Locator locator(h);
    for (int level = 0; level < h.n_levels(); ++level) {
      const Tin tin = tin_of_level(h, level, delaunay::TinLinks::left_out);
      for (std::size_t i = 0; i < c.terrain.points.nodes.size(); i += 3) {
        const LatticePoint p = c.terrain.points.nodes[i];
        const auto found = locator.find(level, delaunay::to_point(p));
        ASSERT_EQ(found.has_value(), c.terrain.domain.triangle_of[i] != delaunay::kNoHalfEdge);
        if (!found) continue;
        EXPECT_TRUE(h.is_in_level(*found, level));
        std::array<LatticePoint, 3> at;
        for (std::size_t k = 0; k < 3; ++k) at[k] = h.vertices[h.triangles[*found].corner[k]];
        EXPECT_TRUE(height_of(at, {}, {p.x * h.scale(), p.y * h.scale()}));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(models, point_hierarchies,
                         testing::Values(PointModel::adaptive, PointModel::delaunay),
                         [](const auto& tested) {
                           return tested.param == PointModel::adaptive ? "adaptive" : "delaunay";
                         });

/// The largest error of an edge at crossings with edges of a TIN, and at vertices on it, in long
/// doubles, by trying all; those next to its ends left out or not.
long double crossing_error(const Tin& tin, std::int32_t scale, const Place& a, const Place& b,
                           double least_distance) {
  long double worst = 0;
  const auto fine = [&](std::uint32_t v) {
    return LatticePoint{tin.vertices[v].x * scale, tin.vertices[v].y * scale};
  };
  const long double length = std::hypot(static_cast<long double>(b.at.x - a.at.x),
                                        static_cast<long double>(b.at.y - a.at.y));
  for (const Corners& t : tin.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t u = t[i];
      const std::uint32_t w = t[(i + 1) % 3];
      const std::int64_t side_u = delaunay::doubled_area(a.at, b.at, fine(u));
      const std::int64_t side_w = delaunay::doubled_area(a.at, b.at, fine(w));
      const std::int64_t side_a = delaunay::doubled_area(fine(u), fine(w), a.at);
      const std::int64_t side_b = delaunay::doubled_area(fine(u), fine(w), b.at);
      const bool crosses = (side_u < 0) != (side_w < 0) && side_u != 0 && side_w != 0 &&
                           (side_a < 0) != (side_b < 0) && side_a != 0 && side_b != 0;
      long double share = 0;
      long double height = 0;
      if (crosses) {
        share = static_cast<long double>(side_a) / static_cast<long double>(side_a - side_b);
        const auto along =
            static_cast<long double>(side_u) / static_cast<long double>(side_u - side_w);
        height =
            tin.heights[u] + (tin.heights[w] - static_cast<long double>(tin.heights[u])) * along;
      } else if (side_u == 0) {
        share = (static_cast<long double>(fine(u).x - a.at.x) * (b.at.x - a.at.x) +
                 static_cast<long double>(fine(u).y - a.at.y) * (b.at.y - a.at.y)) /
                (length * length);
        height = tin.heights[u];
      } else {
        continue;
      }
      if (share <= 0 || share >= 1) continue;
      if (crosses && (share * length < least_distance || (1 - share) * length < least_distance))
        continue;
      worst = std::max(
          worst,
          std::abs(height - (a.height + (b.height - static_cast<long double>(a.height)) * share)));
    }
  return worst;
}

/// Between vertices of all levels, so that ends are points, places on edges and others.
TEST(point_profiles, are_those_of_the_triangulation_from_both_ends) {
  for (const PointCase& c : point_cases()) {
    SCOPED_TRACE(c.name);
    const PointHierarchy made = build_of(c.terrain, PointModel::adaptive);
    const Hierarchy& h = made.hierarchy;
    const double rounding = rounding_of(c.terrain);
    int n_exact = 0;
    for (std::size_t t = 0; t < h.triangles.size(); t += 1 + h.triangles.size() / 400)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t v = h.triangles[t].corner[i];
        const std::uint32_t w = h.triangles[t].corner[(i + 1) % 3];
        const Place a{h.vertices[v], h.heights[v]};
        const Place b{h.vertices[w], h.heights[w]};
        const auto split = made.surface->worst_crossing(a, b);
        const auto back = made.surface->worst_crossing(b, a);
        EXPECT_EQ(split.error, back.error);
        EXPECT_TRUE(split.place.at == back.place.at);
        EXPECT_EQ(split.place.height, back.place.height);
        const Tin& all = made.surface->tin();
        EXPECT_LE(split.error, crossing_error(all, h.scale(), a, b, 0) + rounding);
        EXPECT_GE(split.error, crossing_error(all, h.scale(), a, b, 1) - rounding);
        if (split.error == 0) continue;
        const auto off = static_cast<double>(delaunay::doubled_area(a.at, b.at, split.place.at)) /
                         std::hypot(b.at.x - a.at.x, b.at.y - a.at.y);
        EXPECT_LE(std::abs(off), std::sqrt(0.5) + 1e-9);
        EXPECT_EQ(off == 0, split.is_exact);
        n_exact += split.is_exact;
        const auto exact = made.surface->worst_crossing(a, b, triangle_hierarchy::Crossings::exact);
        EXPECT_LE(exact.error, split.error);
        EXPECT_TRUE(exact.error == 0 || exact.is_exact);
      }
    if (c.name == "on circles") EXPECT_GT(n_exact, 0);
  }
}

TEST(point_samples, are_found_in_triangles_whatever_their_shape) {
  for (const PointCase& c : point_cases()) {
    SCOPED_TRACE(c.name);
    const PointHierarchy made = build_of(c.terrain, PointModel::adaptive, {2}, {20});
    const PointSurface& surface = *made.surface;
    const Tin& all = surface.tin();
    oracles::Random random(6);
    for (int n = 0; n < 200; ++n) {
      std::array<Place, 3> corners;
      for (Place& place : corners) {
        const std::uint32_t v = static_cast<std::uint32_t>(random.below(all.vertices.size()));
        place = {surface.fine(all.vertices[v]), all.heights[v]};
        if (n % 3 == 0) place.at.x = std::max(0, place.at.x - 1);
      }
      const std::int64_t area = delaunay::doubled_area(corners[0].at, corners[1].at, corners[2].at);
      if (area == 0) continue;
      if (area < 0) std::swap(corners[1], corners[2]);
      double worst = 0;
      double inner = 0;
      std::size_t n_held = 0;
      for (std::size_t v = 0; v < all.vertices.size(); ++v) {
        const LatticePoint p = surface.fine(all.vertices[v]);
        const auto height = height_of({corners[0].at, corners[1].at, corners[2].at},
                                      {corners[0].height, corners[1].height, corners[2].height}, p);
        if (!height) continue;
        ++n_held;
        const auto error = static_cast<double>(std::abs(*height - all.heights[v]));
        worst = std::max(worst, error);
        bool is_on_edge = false;
        for (std::size_t i = 0; i < 3; ++i)
          is_on_edge =
              is_on_edge || delaunay::doubled_area(corners[i].at, corners[(i + 1) % 3].at, p) == 0;
        if (!is_on_edge) inner = std::max(inner, error);
      }
      const auto found = surface.measure_samples(corners, triangle_hierarchy::kNoEdges);
      EXPECT_NEAR(found.closed, worst, surface.rounding());
      EXPECT_NEAR(found.inner, inner, surface.rounding());
      EXPECT_EQ(surface.count_samples({corners[0].at, corners[1].at, corners[2].at}), n_held);
    }
  }
}

}  // namespace
}  // namespace lode::test
