// All models of terrain on one grid: what is said of them holds by brute force.
#include "lode/api/terrain_comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "lode/api/built_terrain.h"
#include "lode/api/compared_terrain.h"
#include "lode/api/edge_walk.h"
#include "lode/delaunay/tin_links.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/terrain/height_grids.h"

namespace lode {
namespace {

double ridges(int x, int y) { return 40 * std::sin(0.11 * x) * std::cos(0.17 * y) + 0.3 * x; }

TerrainComparison compared(const HeightGrid& grid, const std::vector<double>& tolerances) {
  Progress progress;
  auto made = compare_terrain(
      grid,
      {.tolerances = tolerances, .n_runs = 1, .n_places = 500, .n_steps = 1000, .threads = {2}},
      progress);
  EXPECT_TRUE(made) << (made ? "" : made.error().message);
  return made ? std::move(*made) : TerrainComparison{};
}

const ComparedModel& named(const TerrainComparison& comparison, const std::string& name) {
  const auto found = std::ranges::find(comparison.models, name, &ComparedModel::name);
  EXPECT_NE(found, comparison.models.end());
  return *found;
}

/// Bilinear squares have another error than triangles; where their continuity is forced, none is
/// promised. All else keeps its tolerance, and what it states.
void expect_error_kept(const ComparedModel& model, const ComparedMesh& mesh) {
  const bool is_forced = model.name == "surface_quadtree, forced";
  EXPECT_EQ(mesh.stated_error.has_value(), !is_forced);
  if (is_forced) EXPECT_LE(mesh.gaps.largest, 1e-9);
  if (is_forced || model.name == "surface_quadtree") return;
  EXPECT_LE(mesh.quality.worst_error, mesh.tolerance + 1e-9);
  EXPECT_LE(mesh.quality.worst_error, *mesh.stated_error + 1e-9);
  if (model.name != "quaternary_triangulation") EXPECT_EQ(mesh.gaps.n_hanging, 0U);
}

/// Four encodings of the same meshes.
void expect_one_pyramid(const TerrainComparison& made) {
  const ComparedModel& pyramid = named(made, "delaunay_pyramid");
  const ComparedModel& lists = named(made, "triangle_lists");
  const ComparedModel& linked = named(made, "linked_triangle_lists");
  const ComparedModel& complete = named(made, "complete_pyramid");
  EXPECT_LT(*lists.memory_bytes, *linked.memory_bytes);
  EXPECT_LT(*linked.n_links, *complete.n_links);
  for (std::size_t i = 0; i < pyramid.meshes.size(); ++i) {
    EXPECT_FALSE(lists.meshes[i].zoom_seconds);
    EXPECT_TRUE(pyramid.meshes[i].located_per_second);
    for (const ComparedModel* other : {&lists, &linked, &complete})
      EXPECT_EQ(other->meshes[i].triangles, pyramid.meshes[i].triangles);
    for (const ComparedModel* other : {&linked, &complete})
      EXPECT_EQ(other->meshes[i].zoom_triangles, pyramid.meshes[i].zoom_triangles);
  }
  EXPECT_LT(pyramid.meshes[2].variable_triangles, pyramid.meshes[2].triangles);
}

/// What has no value has a reason, and what has one has none.
void expect_reasons(const TerrainComparison& made) {
  for (const ComparedModel& model : made.models) {
    SCOPED_TRACE(model.name);
    const auto expect = [&](const char* what, bool is_there) {
      const auto found = std::ranges::find(model.missing, what, &ComparedModel::Missing::what);
      EXPECT_EQ(found == model.missing.end(), is_there) << what;
      if (found != model.missing.end()) EXPECT_GT(found->why.size(), 5U) << what;
    };
    const auto all_have = [&](auto member) {
      return std::ranges::all_of(
          model.meshes, [&](const ComparedMesh& mesh) { return (mesh.*member).has_value(); });
    };
    expect("levels", model.n_levels > 0);
    expect("memory", model.memory_bytes.has_value());
    expect("building took", model.peak_bytes.has_value());
    expect("file", model.file_bytes.has_value());
    expect("links", model.n_links.has_value());
    expect("variable", all_have(&ComparedMesh::variable_seconds));
    expect("zoom", all_have(&ComparedMesh::zoom_seconds));
    expect("found", all_have(&ComparedMesh::located_per_second));
    expect("steps", all_have(&ComparedMesh::crossed_per_second));
    expect("contours", all_have(&ComparedMesh::contour_seconds));
    expect("profile", all_have(&ComparedMesh::profile_seconds));
    // Whatever keeps something is known by its bytes, and making anything takes some.
    const bool keeps_some = !model.is_made_anew;
    EXPECT_EQ(model.memory_bytes.has_value(), keeps_some);
    EXPECT_TRUE(model.peak_bytes);
  }
  for (const char* name : {"surface_quadtree", "quaternary_triangulation"}) {
    const ComparedMesh& mesh = named(made, name).meshes[2];
    EXPECT_LT(mesh.variable_triangles, mesh.triangles) << name;
    EXPECT_GT(mesh.variable_triangles, named(made, name).meshes[0].triangles) << name;
  }
}

/// Squares with gaps are asked without a mesh, and gone along on their own surface; where that is
/// not in their nature, the page says why.
void expect_quadtrees_asked(const TerrainComparison& made) {
  for (const char* name : {"surface_quadtree", "quaternary_triangulation"})
    for (const ComparedMesh& mesh : named(made, name).meshes) {
      SCOPED_TRACE(testing::Message() << name << ", " << mesh.tolerance);
      EXPECT_TRUE(mesh.variable_seconds && mesh.zoom_seconds && mesh.located_per_second);
      EXPECT_GT(mesh.variable_triangles, 0U);
      EXPECT_LE(mesh.variable_triangles, mesh.triangles);
      EXPECT_GT(mesh.zoom_triangles, 0U);
      EXPECT_LT(mesh.zoom_triangles, mesh.triangles);
      EXPECT_TRUE(mesh.profile_seconds);
      EXPECT_GT(mesh.profile_points, 1U);
    }
  const ComparedModel& forced = named(made, "surface_quadtree, forced");
  EXPECT_TRUE(forced.meshes[0].variable_seconds);
  for (const ComparedModel* model : {&forced, &named(made, "restricted_quadtree")}) {
    EXPECT_FALSE(model->meshes[0].zoom_seconds || model->meshes[0].located_per_second);
    EXPECT_NE(model->what.find("before"), std::string::npos) << model->what;
  }
}

/// Who keeps no neighbours says so; all others cross edges, and whatever there is took time to be
/// built.
void expect_neighbours(const TerrainComparison& made) {
  for (const ComparedModel& model : made.models) {
    SCOPED_TRACE(model.name);
    EXPECT_FALSE(model.neighbours.empty());
    EXPECT_TRUE(model.build_seconds);
    const bool has_none = model.name == "triangle_lists" || model.name == "linked_triangle_lists" ||
                          model.name == "surface_quadtree" ||
                          model.name == "surface_quadtree, forced" ||
                          model.name == "quaternary_triangulation";
    for (const ComparedMesh& mesh : model.meshes) {
      EXPECT_EQ(mesh.crossed_per_second.has_value(), !has_none);
      if (!has_none) EXPECT_GT(*mesh.crossed_per_second, 0);
      EXPECT_EQ(mesh.twins_seconds.has_value(),
                !model.name.starts_with("delaunay_selector") && model.name != "complete_pyramid");
    }
  }
  EXPECT_TRUE(named(made, "delaunay_selector").is_made_anew);
  EXPECT_TRUE(named(made, "restricted_quadtree").is_made_anew);
  EXPECT_FALSE(named(made, "delaunay_pyramid").is_made_anew);
}

TEST(terrain_comparison, has_every_model_within_every_tolerance) {
  // Odd sizes, of which none is a power of two and one more.
  const TerrainComparison made = compared(test::float_grid(90, 61, ridges), {20, 5, 1, 0});
  EXPECT_EQ(made.models.size(), 16U);
  EXPECT_EQ(made.n_samples, 90U * 61U);
  for (const ComparedModel& model : made.models) {
    SCOPED_TRACE(model.name);
    EXPECT_EQ(model.refusal, "");
    ASSERT_EQ(model.meshes.size(), 4U);
    for (const ComparedMesh& mesh : model.meshes) {
      expect_error_kept(model, mesh);
      EXPECT_LE(mesh.quality.rms_error, mesh.quality.worst_error);
      EXPECT_EQ(mesh.quality.n_uncovered, 0U);
      EXPECT_EQ(mesh.quality.n_samples, made.n_samples);
      std::uint64_t n = 0;
      for (const std::uint64_t in_step : mesh.quality.angles.counts) n += in_step;
      EXPECT_EQ(n, mesh.triangles);
      EXPECT_EQ(mesh.contour_seconds.has_value(), mesh.gaps.n_hanging == 0);
      if (mesh.gaps.n_hanging == 0) {
        EXPECT_GT(mesh.contour_points, 0U);
        EXPECT_GT(mesh.profile_points, 1U);
      }
      EXPECT_GT(mesh.places_per_second, 0);
    }
    // Finer is more.
    EXPECT_LT(model.meshes[0].triangles, model.meshes[3].triangles);
  }
  EXPECT_LT(named(made, "delaunay_selector").meshes[1].triangles,
            named(made, "right_triangle_bisection").meshes[1].triangles);
  EXPECT_TRUE(named(made, "right_triangle_bisection").meshes[1].variable_seconds);
  EXPECT_LT(named(made, "right_triangle_bisection").meshes[1].variable_triangles,
            named(made, "right_triangle_bisection").meshes[1].triangles);
  EXPECT_FALSE(named(made, "regular grid").meshes[0].variable_seconds);
  expect_one_pyramid(made);
  expect_neighbours(made);
  expect_reasons(made);
  expect_quadtrees_asked(made);
}

TEST(terrain_comparison, has_the_levels_that_models_have_of_themselves) {
  const HeightGrid grid = test::float_grid(90, 61, ridges);
  Progress progress;
  const TerrainComparison made = compared(grid, {20, 5});
  for (const ComparedModel& model : made.models) {
    SCOPED_TRACE(model.name);
    EXPECT_FALSE(model.levels_are.empty());
    const bool is_anew =
        model.name.starts_with("delaunay_selector") || model.name == "regular grid";
    EXPECT_EQ(model.n_levels == 0, is_anew);
    EXPECT_EQ(model.levels_are.starts_with("none"), is_anew);
  }
  // Those of the model, whatever tolerances are asked for.
  const auto implicit =
      BuiltTerrain::build(grid, {.model = TerrainModel::implicit_delaunay_pyramid}, progress);
  ASSERT_TRUE(implicit);
  const auto info = implicit->describe(progress);
  ASSERT_TRUE(info);
  EXPECT_GT(info->levels.size(), 5U);
  EXPECT_EQ(named(made, "implicit_delaunay_pyramid").n_levels,
            static_cast<int>(info->levels.size()));
  EXPECT_GT(named(made, "ternary_triangulation").n_levels, 4);
  EXPECT_GT(named(compared(grid, {20, 1}), "ternary_triangulation").n_levels,
            named(made, "ternary_triangulation").n_levels);
  EXPECT_EQ(named(made, "complete_pyramid").n_levels, 2);
  EXPECT_EQ(named(made, "adaptive_triangulation").n_levels, 2);
  // 2^7 cells are the least power of two that is no less than 89.
  for (const char* name : {"surface_quadtree", "quaternary_triangulation", "restricted_quadtree"})
    EXPECT_EQ(named(made, name).n_levels, 8) << name;
}

TEST(terrain_comparison, measures_what_making_the_finest_mesh_takes) {
  const TerrainComparison made = compared(test::float_grid(250, 250, ridges), {5, 0.1});
  for (const char* name :
       {"delaunay_selector", "delaunay_selector, strict", "restricted_quadtree", "regular grid"}) {
    const ComparedModel& model = named(made, name);
    ASSERT_TRUE(model.peak_bytes) << name;
    // Corners of triangles and places of vertices at least; a few pages may have been there.
    EXPECT_GT(*model.peak_bytes + (1 << 18), 12 * model.meshes[1].triangles) << name;
    EXPECT_GT(12 * model.meshes[1].triangles, 1U << 19) << name;
  }
}

TEST(terrain_comparison, measures_true_errors_of_high_heights) {
  // Centimetres, of which float64 has all bits, at 1e9; and the same at 0, in its units.
  const auto relief = [](int x, int y) {
    return std::round(0x1p23 * 3 * std::sin(0.3 * x) * std::cos(0.2 * y)) * 0x1p-23;
  };
  const HeightGrid low = delaunay::test::make_grid<double>(57, 40, relief);
  const HeightGrid high =
      delaunay::test::make_grid<double>(57, 40, [&](int x, int y) { return 1e9 + relief(x, y); });
  const TerrainComparison at_zero = compared(low, {1, 0.02});
  const TerrainComparison made = compared(high, {1, 0.02});
  for (const char* name : {"surface_quadtree", "quaternary_triangulation", "restricted_quadtree",
                           "right_triangle_bisection", "delaunay_selector, strict"}) {
    SCOPED_TRACE(name);
    const ComparedModel& model = named(made, name);
    ASSERT_EQ(model.meshes.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      const ComparedMesh& mesh = model.meshes[i];
      const ComparedMesh& same = named(at_zero, name).meshes[i];
      EXPECT_LE(mesh.rounding, 1e-14);
      if (model.name != "surface_quadtree") EXPECT_TRUE(mesh.is_met()) << mesh.quality.worst_error;
      if (mesh.triangles != same.triangles) continue;
      EXPECT_EQ(mesh.quality.worst_error, same.quality.worst_error);
    }
    // Quadtrees split by the same errors, wherever they are.
    if (model.name.ends_with("quadtree"))
      EXPECT_EQ(model.meshes[1].triangles, named(at_zero, name).meshes[1].triangles);
  }
}

TEST(terrain_comparison, runs_no_model_whose_links_take_more_than_the_limit) {
  Progress progress;
  const auto made = compare_terrain(
      test::float_grid(40, 40, ridges),
      {.tolerances = {20, 5}, .n_runs = 1, .n_places = 10, .n_steps = 10, .memory_limit = 64},
      progress);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->memory_limit, 64U);
  for (const char* name : {"linked_triangle_lists", "complete_pyramid"})
    EXPECT_NE(named(*made, name).refusal.find("up to 64 bytes"), std::string::npos) << name;
  EXPECT_EQ(named(*made, "triangle_lists").refusal, "");
}

TEST(edge_walk, goes_on_until_the_outline_and_turns_there) {
  // A strip of triangles, each with one behind edges 1 and 2 but for the ends.
  constexpr std::uint32_t kTriangles = 9;
  std::vector<std::uint32_t> visits(kTriangles, 0);
  const std::uint64_t n = walk_edges(4, 1000, 7, [&](std::uint32_t triangle, unsigned edge) {
    EXPECT_LT(triangle, kTriangles);
    ++visits[triangle];
    if (edge == 1 && triangle + 1 < kTriangles) return 4 * (triangle + 1) + 2;
    if (edge == 2 && triangle > 0) return 4 * (triangle - 1) + 1;
    return delaunay::kNoHalfEdge;
  });
  EXPECT_GT(n, 100U);
  EXPECT_LT(n, 1000U);
  for (const std::uint32_t v : visits) EXPECT_GT(v, 0U);
}

TEST(edge_walk, knows_what_is_behind_the_edges_of_a_grid) {
  constexpr std::uint32_t kColumns = 5;
  constexpr std::uint32_t kRows = 3;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t y = 0; y < kRows; ++y)
    for (std::uint32_t x = 0; x < kColumns; ++x) {
      const std::uint32_t a = y * (kColumns + 1) + x;
      triangles.push_back({a, a + 1, a + kColumns + 2});
      triangles.push_back({a, a + kColumns + 2, a + kColumns + 1});
    }
  const auto twins = delaunay::find_twins(triangles);
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (unsigned edge = 0; edge < 3; ++edge)
      EXPECT_EQ(behind_in_grid(kColumns, kRows, t, edge), twins[t][edge]) << t << ", " << edge;
}

TEST(terrain_comparison, says_why_a_model_is_not_run) {
  HeightGrid grid = test::float_grid(40, 40, ridges);
  grid.is_valid.assign(1600, 1);
  grid.is_valid[820] = 0;
  const TerrainComparison made = compared(grid, {3});
  EXPECT_NE(named(made, "regular grid").refusal.find("1 missing"), std::string::npos);
  EXPECT_LE(named(made, "delaunay_selector").meshes[0].quality.worst_error, 3);
  EXPECT_LE(named(made, "right_triangle_bisection").meshes[0].quality.worst_error, 3);
}

TEST(terrain_comparison, is_the_same_but_for_times_for_any_number_of_threads) {
  const HeightGrid grid = test::float_grid(50, 40, ridges);
  Progress progress;
  const auto counts = [&](int threads) {
    const auto made = compare_terrain(
        grid, {.tolerances = {2}, .n_runs = 1, .n_places = 10, .n_steps = 10, .threads = {threads}},
        progress);
    std::vector<double> numbers;
    for (const ComparedModel& model : made->models)
      for (const ComparedMesh& mesh : model.meshes)
        for (const double x : {static_cast<double>(mesh.triangles), mesh.quality.worst_error,
                               mesh.quality.rms_error, mesh.quality.angles.median})
          numbers.push_back(x);
    return numbers;
  };
  EXPECT_EQ(counts(1), counts(3));
}

TEST(terrain_comparison, refuses_options_and_grids_that_are_none) {
  Progress progress;
  const HeightGrid grid = test::float_grid(5, 5, ridges);
  EXPECT_FALSE(compare_terrain(grid, {.tolerances = {}}, progress));
  EXPECT_FALSE(compare_terrain(grid, {.tolerances = {-1}}, progress));
  EXPECT_FALSE(compare_terrain(test::float_grid(5, 1, ridges), {.tolerances = {1}}, progress));
}

/// Of two triangles over 4 x 4 samples of a plane, one sample off by 2.
TEST(tin_quality, is_that_of_brute_force) {
  HeightGrid grid =
      test::float_grid(4, 4, [](int x, int y) { return x == 1 && y == 2 ? 5 : x + y; });
  delaunay::Tin tin;
  tin.vertices = {{0, 0}, {6, 0}, {0, 6}, {6, 6}};  // at a scale of 2
  tin.heights = {0, 3, 3, 6};
  tin.triangles = {{0, 1, 3}, {0, 3, 2}};
  const TinQuality quality = measure_quality(tin, 2, grid, {1});
  EXPECT_EQ(quality.n_samples, 16U);
  EXPECT_EQ(quality.n_uncovered, 0U);
  EXPECT_DOUBLE_EQ(quality.worst_error, 2);
  EXPECT_DOUBLE_EQ(quality.rms_error, 0.5);
  EXPECT_NEAR(quality.angles.smallest, 45, 1e-12);
  EXPECT_EQ(quality.angles.counts[8] + quality.angles.counts[9], 2U);
  tin.triangles.pop_back();
  EXPECT_EQ(measure_quality(tin, 2, grid, {1}).n_uncovered, 6U);
}

TEST(tin_links, are_those_of_brute_force) {
  delaunay::Tin tin;
  const auto index = [](std::uint32_t x, std::uint32_t y) { return 9 * y + x; };
  for (std::uint32_t y = 0; y < 8; ++y)
    for (std::uint32_t x = 0; x < 8; ++x) {
      if ((x == 3 || x == 4) && y == 5) continue;  // a hole
      tin.triangles.push_back({index(x, y), index(x + 1, y), index(x + 1, y + 1)});
      tin.triangles.push_back({index(x, y), index(x + 1, y + 1), index(x, y + 1)});
    }
  std::mt19937 random(3);
  std::ranges::shuffle(tin.triangles, random);
  const auto twins = delaunay::find_twins(tin.triangles);
  for (std::uint32_t t = 0; t < tin.triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      std::uint32_t expected = delaunay::kNoHalfEdge;
      for (std::uint32_t u = 0; u < tin.triangles.size(); ++u)
        for (std::uint32_t k = 0; k < 3; ++k)
          if (tin.triangles[u][k] == tin.triangles[t][(i + 1) % 3] &&
              tin.triangles[u][(k + 1) % 3] == tin.triangles[t][i])
            expected = 4 * u + k;
      EXPECT_EQ(twins[t][i], expected);
    }
}

}  // namespace
}  // namespace lode
