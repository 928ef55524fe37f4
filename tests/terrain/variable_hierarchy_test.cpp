// Tolerances that vary over hierarchies of triangles, with the raster and without.
#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"
#include "lode/models/terrain/triangle_hierarchy/variable.h"
#include "lode/refine/focus.h"
#include "tests/terrain/hierarchy_fixtures.h"

namespace lode::test {
namespace {

using delaunay::Tin;
using triangle_hierarchy::BoundedPatches;
using triangle_hierarchy::EdgeChains;
using triangle_hierarchy::FineGrid;
using triangle_hierarchy::MeasuredPatches;
using triangle_hierarchy::Patch;
using triangle_hierarchy::PatchErrors;
using triangle_hierarchy::Place;

struct Varying {
  FineGrid grid;
  Hierarchy hierarchy;
  EdgeChains chains;
};

enum class Kind : std::uint8_t { adaptive, delaunay };
enum class Raster : std::uint8_t { measured, bounded };

Varying build_varying(const HeightGrid& heights, Kind model,
                      std::span<const double> levels = kLevels) {
  Progress progress;
  auto grid = FineGrid::make(heights);
  EXPECT_TRUE(grid);
  Hierarchy hierarchy;
  if (model == Kind::adaptive) {
    auto made = adaptive_triangulation::build(*grid, levels, {2}, progress);
    EXPECT_TRUE(made);
    hierarchy = std::move(made->hierarchy);
  } else {
    auto made = hierarchical_delaunay::build(*grid, levels, {2}, progress);
    EXPECT_TRUE(made);
    hierarchy = std::move(made->hierarchy);
  }
  auto chains = EdgeChains::find_in(hierarchy);
  EXPECT_TRUE(chains);
  return {*std::move(grid), std::move(hierarchy), *std::move(chains)};
}

Tin vary(const Varying& built, Raster raster, const Demand& demand) {
  return raster == Raster::measured
             ? tin_of_demand(built.hierarchy, built.chains, MeasuredPatches(built.grid), demand)
             : tin_of_demand(built.hierarchy, built.chains, BoundedPatches(built.hierarchy),
                             demand);
}

Box3d world_box(double x_low, double y_low, double x_high, double y_high) {
  return {{{x_low, y_low, -1e9}}, {{x_high, y_high, 1e9}}};
}

FocusDemand focus_on(const Box3d& box, double inside, double outside) {
  FocusDemand focus;
  focus.foci = {BoxFocus{box}};
  focus.inside = inside;
  focus.outside = outside;
  return focus;
}

class variable_hierarchy : public testing::TestWithParam<std::pair<Kind, Raster>> {
 protected:
  [[nodiscard]] static Varying build_model(const HeightGrid& heights,
                                           std::span<const double> levels = kLevels) {
    return build_varying(heights, GetParam().first, levels);
  }
  [[nodiscard]] static Tin vary(const Varying& built, const Demand& demand) {
    return test::vary(built, GetParam().second, demand);
  }
};

TEST_P(variable_hierarchy, keeps_every_demand) {
  for (const TerrainCase& c : terrain_cases()) {
    const Varying built = build_model(c.grid);
    const Hierarchy& h = built.hierarchy;
    oracles::Random random(3);
    for (int n = 0; n < 8; ++n) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << n);
      const double x = random.uniform(0, c.grid.n_columns);
      const double y = random.uniform(0, c.grid.n_rows);
      // Errors are kept rounded up, so the last tolerance is a little larger.
      const auto focus =
          focus_on(world_box(x, y, x + 7, y + 5), n % 2 == 0 ? 7.5 : 0.01, n % 4 < 2 ? 200 : 45);
      const Tin tin = vary(built, focus);
      delaunay::test::expect_fills(tin, c.grid, h.scale());
      expect_within(tin, h.scale(), c.grid, focus.outside);
      for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
        const auto at = [&](std::size_t i) { return tin.vertices[tin.triangles[t][i]]; };
        const double scale = h.scale();
        if (std::max({at(0).x, at(1).x, at(2).x}) / scale < x ||
            std::min({at(0).x, at(1).x, at(2).x}) / scale > x + 7 ||
            std::max({at(0).y, at(1).y, at(2).y}) / scale < y ||
            std::min({at(0).y, at(1).y, at(2).y}) / scale > y + 5)
          continue;
        EXPECT_LE(static_cast<double>(tin.errors[t]), focus.inside);
      }
      const auto finest = tin_of_level(h, h.n_levels() - 1, delaunay::TinLinks::left_out);
      EXPECT_LE(tin.triangles.size(), finest.triangles.size());
    }
  }
}

TEST_P(variable_hierarchy, goes_from_the_first_level_to_the_last) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const Varying built = build_model(c.grid);
    const Hierarchy& h = built.hierarchy;
    const Tin first = vary(built, Demand());
    EXPECT_EQ(first.triangles, tin_of_level(h, 0, delaunay::TinLinks::left_out).triangles);
    const Tin all = vary(built, uniform_demand(0));
    const auto finest = tin_of_level(h, h.n_levels() - 1, delaunay::TinLinks::left_out);
    EXPECT_EQ(all.triangles, finest.triangles);
    EXPECT_EQ(all.vertices, finest.vertices);
  }
}

TEST_P(variable_hierarchy, is_much_smaller_where_only_a_part_must_be_fine) {
  const HeightGrid grid = make_grid<float>(129, 129, hills_with_spikes);
  const std::array levels{100.0, 30.0, 10.0, 3.0, 1.0};
  const Varying built = build_model(grid, levels);
  const Tin tin = vary(built, focus_on(world_box(50, 50, 66, 66), 1.1, 200));
  const auto finest = tin_of_level(built.hierarchy, 4, delaunay::TinLinks::left_out);
  EXPECT_LT(tin.triangles.size(), finest.triangles.size() / 4);
}

INSTANTIATE_TEST_SUITE_P(models, variable_hierarchy,
                         testing::Values(std::pair(Kind::adaptive, Raster::measured),
                                         std::pair(Kind::adaptive, Raster::bounded),
                                         std::pair(Kind::delaunay, Raster::measured),
                                         std::pair(Kind::delaunay, Raster::bounded)),
                         [](const auto& tested) {
                           return std::string(tested.param.first == Kind::adaptive ? "adaptive"
                                                                                   : "delaunay") +
                                  (tested.param.second == Raster::measured ? "_measured"
                                                                           : "_bounded");
                         });

using Places = std::array<std::array<std::int32_t, 2>, 3>;

Places places_of(const std::array<std::uint32_t, 3>& corner,
                 const std::vector<LatticePoint>& vertices) {
  Places places{};
  for (std::size_t i = 0; i < 3; ++i) places[i] = {vertices[corner[i]].x, vertices[corner[i]].y};
  std::ranges::sort(places);
  return places;
}

/// A sliver between vertices of a chain has no samples in it, and would be a wall.
TEST(measured_patches, state_errors_of_edges_between_levels) {
  int n_edges = 0;
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const Varying built = build_varying(c.grid, Kind::delaunay);
    const Hierarchy& h = built.hierarchy;
    std::set<Places> own;
    std::set<std::array<std::array<std::int32_t, 2>, 2>> edges;
    for (const auto& triangle : h.triangles) {
      const Places places = places_of(triangle.corner, h.vertices);
      own.insert(places);
      for (const auto& [i, k] : {std::pair{0U, 1U}, {0U, 2U}, {1U, 2U}})
        edges.insert({places[i], places[k]});
    }
    const Tin tin = vary(built, Raster::measured, focus_on(world_box(2, 2, 6, 6), 0.01, 200));
    for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
      const auto& corner = tin.triangles[t];
      if (own.contains(places_of(corner, tin.vertices))) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto at = [&](std::size_t k) {
          const std::uint32_t v = corner[(i + k) % 3];
          return Place{tin.vertices[v], tin.heights[v]};
        };
        std::array<std::array<std::int32_t, 2>, 2> edge{};
        for (std::size_t k = 0; k < 2; ++k) edge[k] = {at(k).at.x, at(k).at.y};
        std::ranges::sort(edge);
        if (edges.contains(edge)) continue;
        ++n_edges;
        EXPECT_LE(worst_crossing(built.grid, at(0), at(1)).error,
                  static_cast<double>(tin.errors[t]));
      }
    }
  }
  EXPECT_GT(n_edges, 50);
}

/// One triangle, (0, 0), (10, 1), (0, 8), that errs by 2, on a raster's own nodes.
Hierarchy one_triangle() {
  Hierarchy h;
  h.vertices = {{0, 0}, {10, 1}, {0, 8}};
  h.heights = {0, 10, 0};
  h.triangles = {{.corner = {0, 1, 2},
                  .twin = {delaunay::kNoHalfEdge, delaunay::kNoHalfEdge, delaunay::kNoHalfEdge},
                  .error = 2}};
  return h;
}

TEST(bounded_patches, add_how_far_a_chain_is_from_the_plane) {
  const Hierarchy h = one_triangle();
  // 0.5 of the first edge: 5 high in the triangle.
  const Patch patch{.places = {{{0, 0}, 0}, {{5, 1}, 8}, {{10, 1}, 10}, {{0, 8}, 0}},
                    .triangles = {{0, 1, 3}, {1, 2, 3}}};
  const std::vector<double> errors = BoundedPatches(h).of(0, patch);
  ASSERT_EQ(errors.size(), 2U);
  for (const double error : errors) {
    EXPECT_GE(error, 2 + 3);
    EXPECT_LE(error, 2 + 3 + 1e-9);
  }
}

TEST(bounded_patches, know_nothing_of_samples_that_a_chain_takes_from_a_neighbour) {
  Hierarchy h = one_triangle();
  // (5, 0) is below the edge, and above the chain; so is (8, 0), on it.
  const auto patch_through = [](LatticePoint place) {
    return Patch{.places = {{{0, 0}, 0}, {place, 5}, {{10, 1}, 10}, {{0, 8}, 0}},
                 .triangles = {{0, 1, 3}, {1, 2, 3}}};
  };
  EXPECT_TRUE(BoundedPatches(h).of(0, patch_through({5, -1})).empty());
  EXPECT_TRUE(BoundedPatches(h).of(0, patch_through({8, 0})).empty());
  EXPECT_EQ(BoundedPatches(h).of(0, patch_through({2, 1})).size(), 2U);
  // Where nodes are sixteen apart no sample is there.
  h.bits = 4;
  EXPECT_EQ(BoundedPatches(h).of(0, patch_through({5, -1})).size(), 2U);
}

TEST(edge_chains, are_refused_where_a_refinement_leaves_its_triangle) {
  Varying built = build_varying(make_grid<float>(33, 29, hills_with_spikes), Kind::delaunay);
  ASSERT_GE(built.hierarchy.refinements.size(), 2U);
  std::swap(built.hierarchy.refinements[0].triangle, built.hierarchy.refinements[1].triangle);
  EXPECT_FALSE(EdgeChains::find_in(built.hierarchy));
}

}  // namespace
}  // namespace lode::test
