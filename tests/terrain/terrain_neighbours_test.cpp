// Triangles that hold places, and those beside them, of all models.
#include "lode/api/terrain_neighbours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "lode/api/built_terrain.h"
#include "lode/api/round_terrain.h"
#include "lode/api/terrain_selection.h"
#include "tests/locate/edge_pairs.h"
#include "tests/terrain/point_terrains.h"

namespace lode {
namespace {

/// Rows from the north, with a gap; places in the world are whole numbers, also of lattices up to
/// 4096 times as fine.
HeightGrid neighbour_grid() {
  HeightGrid grid = test::float_grid(41, 33, [](int x, int y) {
    return 40 * std::sin(0.2 * x) * std::cos(0.15 * y) + (x * 7 + y * 5) % 9;
  });
  for (std::int32_t x = 12; x < 17; ++x) delaunay::test::set_missing(grid, x, 9);
  delaunay::test::set_missing(grid, 0, 0);
  grid.to_world = {500, 3 * 4096, 0, 9000, 0, -2 * 4096};
  return grid;
}

TerrainTin triangles_of(const Terrain& terrain, const TerrainOptions& options,
                        const HorizontalMetric& metric = {}) {
  Progress progress;
  auto tin = TerrainTin::select(terrain, options, metric, progress, TinUse::triangles);
  EXPECT_TRUE(tin) << tin.error().message;
  return std::move(tin).value();
}

std::vector<TerrainNeighbours> neighbours_of(const TerrainTin& tin,
                                             const std::vector<Place>& places,
                                             std::uint32_t n_rings, int n_threads = 1) {
  Progress progress;
  std::vector<TerrainNeighbours> answers;
  const auto report =
      tin.neighbours(places, {.n_rings = n_rings, .threads = {n_threads}}, answers, progress);
  EXPECT_TRUE(report) << report.error().message;
  EXPECT_EQ(answers.size(), places.size());
  return answers;
}

Place middle_of(const std::array<Vec3d, 3>& corners) {
  const Vec3d sum = corners[0] + corners[1] + corners[2];
  return {{sum[0] / 3, sum[1] / 3}};
}

/// Asks for each triangle of the mesh at its middle; corners are those that extraction has.
std::vector<TerrainTriangle> every_triangle(const Terrain& terrain, const TerrainOptions& options,
                                            const TerrainTin& tin) {
  Progress progress;
  const auto mesh = terrain.origin().select(options, delaunay::TinLinks::left_out, progress);
  EXPECT_TRUE(mesh) << mesh.error().message;
  std::vector<Place> places;
  std::vector<std::array<Vec3d, 3>> corners;
  for (const auto& triangle : mesh->tin.triangles) {
    std::array<Vec3d, 3>& of_it = corners.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const LatticePoint p = mesh->tin.vertices[triangle[i]];
      const Place at = terrain.frame().world(p.x, p.y);
      of_it[i] = {{at[0], at[1], mesh->tin.heights[triangle[i]]}};
    }
    places.push_back(middle_of(of_it));
  }
  std::vector<TerrainTriangle> all;
  const auto answers = neighbours_of(tin, places, 0);
  for (std::uint32_t t = 0; t < answers.size(); ++t) {
    EXPECT_EQ(answers[t].where, TerrainHeight::Where::inside);
    EXPECT_EQ(answers[t].triangles.size(), 1U);
    const TerrainTriangle& one = all.emplace_back(answers[t].triangles.front());
    EXPECT_EQ(one.triangle, t);
    EXPECT_EQ(one.ring, 0U);
    EXPECT_TRUE(std::ranges::is_permutation(one.corners, corners[t]));
  }
  return all;
}

/// Whole numbers in the world are as good as a lattice.
delaunay::Tin world_tin(const std::vector<TerrainTriangle>& triangles) {
  delaunay::Tin tin;
  for (const TerrainTriangle& one : triangles) {
    const auto first = static_cast<std::uint32_t>(tin.vertices.size());
    tin.triangles.push_back({first, first + 1, first + 2});
    for (const Vec3d& p : one.corners)
      tin.vertices.push_back({static_cast<std::int32_t>(std::lround(p[0])),
                              static_cast<std::int32_t>(std::lround(p[1]))});
    EXPECT_GT(delaunay::doubled_area(tin.vertices[first], tin.vertices[first + 1],
                                     tin.vertices[first + 2]),
              0);
  }
  return tin;
}

/// How many lie beside more than one along an edge.
std::size_t expect_beside(const std::vector<TerrainTriangle>& triangles,
                          const test::EdgePairs& pairs) {
  std::size_t n_several = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    std::vector<TerrainTriangle::Beside> wanted;
    for (std::uint8_t edge = 0; edge < 3; ++edge)
      for (const test::PairedEdge& other : pairs[t][edge]) {
        wanted.push_back({edge, static_cast<std::uint8_t>(other.edge), other.triangle});
        n_several += pairs[t][edge].size() > 1 ? 1 : 0;
      }
    EXPECT_EQ(triangles[t].beside, wanted) << t;
  }
  return n_several;
}

void expect_rings(const TerrainTin& tin, const std::vector<TerrainTriangle>& triangles,
                  const test::EdgePairs& pairs) {
  for (std::uint32_t t = 0; t < triangles.size(); t += 37) {
    const std::vector<std::uint32_t> steps = test::steps_from(pairs, {&t, 1});
    for (const std::uint32_t n_rings : {1U, 3U}) {
      const auto answer =
          neighbours_of(tin, {middle_of(triangles[t].corners)}, n_rings).front().triangles;
      EXPECT_EQ(answer.size(), static_cast<std::size_t>(std::ranges::count_if(
                                   steps, [&](std::uint32_t n) { return n <= n_rings; })));
      for (std::size_t i = 0; i < answer.size(); ++i) {
        EXPECT_EQ(answer[i].ring, steps[answer[i].triangle]);
        EXPECT_EQ(answer[i].corners, triangles[answer[i].triangle].corners);
        EXPECT_EQ(answer[i].beside, triangles[answer[i].triangle].beside);
        if (i > 0)
          EXPECT_LT(std::pair(answer[i - 1].ring, answer[i - 1].triangle),
                    std::pair(answer[i].ring, answer[i].triangle));
      }
    }
  }
}

/// By the plane of each triangle, at each sample in it.
void expect_bounds(const std::vector<TerrainTriangle>& triangles, const HeightGrid& grid) {
  std::size_t n_in_triangles = 0;
  for (const TerrainTriangle& one : triangles) {
    const auto& [a, b, c] = one.corners;
    const auto area = [](const Vec3d& p, const Vec3d& q, const Place& r) {
      return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    };
    for (std::int32_t y = 0; y < grid.n_rows; ++y)
      for (std::int32_t x = 0; x < grid.n_columns; ++x) {
        const Place at = grid.world(x, y);
        const double u = area(b, c, at);
        const double v = area(c, a, at);
        const double w = area(a, b, at);
        if (u < 0 || v < 0 || w < 0) continue;
        ++n_in_triangles;
        const double z = (u * a[2] + v * b[2] + w * c[2]) / (u + v + w);
        // Of heights below 64: 2^-40 is more than rounding of the sums.
        EXPECT_LE(std::abs(z - grid.height(x, y)), one.bound + 0x1p-40);
      }
  }
  EXPECT_GT(n_in_triangles, 1000U);
}

TEST(terrain_neighbours, share_edges_in_every_model_of_a_raster) {
  const HeightGrid grid = neighbour_grid();
  Progress progress;
  const TerrainOptions options{.max_error = 6};
  const std::string path = testing::TempDir() + "lode_neighbours.lode";
  const auto expect_model = [&](const Terrain& terrain, bool has_gaps) {
    const TerrainTin tin = triangles_of(terrain, options);
    const auto triangles = every_triangle(terrain, options, tin);
    EXPECT_GT(triangles.size(), 100U);
    const test::EdgePairs pairs = test::pair_by_trying(world_tin(triangles));
    EXPECT_EQ(expect_beside(triangles, pairs) > 0, has_gaps);
    expect_rings(tin, triangles, pairs);
    expect_bounds(triangles, grid);
  };
  expect_model(grid, false);
  for (const TerrainModel model : kBuiltTerrainModels) {
    SCOPED_TRACE(name_of(model));
    const auto built = BuiltTerrain::build(grid, {.model = model, .levels = {12, 6, 3}}, progress);
    ASSERT_TRUE(built) << built.error().message;
    expect_model(built->terrain(), has_gaps(model));
    ASSERT_TRUE(built->save(path, progress));
    const auto opened = BuiltTerrain::open(path, progress);
    ASSERT_TRUE(opened) << opened.error().message;
    expect_model(opened->terrain(), has_gaps(model));
  }
  std::filesystem::remove(path);
}

TEST(terrain_neighbours, share_edges_in_every_model_of_points_and_lines) {
  Progress progress;
  for (const test::PointCase& one : test::point_cases()) {
    const auto expect_model = [&](const Terrain& terrain) {
      const TerrainOptions options{.max_error = 2};
      const TerrainTin tin = triangles_of(terrain, options);
      const auto mesh = terrain.origin().select(options, delaunay::TinLinks::left_out, progress);
      ASSERT_TRUE(mesh);
      // On their lattice, as places in the world are no whole numbers.
      const test::EdgePairs pairs = test::pair_by_trying(mesh->tin);
      for (const TerrainTriangle& triangle : every_triangle(terrain, options, tin)) {
        std::vector<TerrainTriangle::Beside> wanted;
        for (std::uint8_t edge = 0; edge < 3; ++edge)
          for (const test::PairedEdge& other : pairs[triangle.triangle][edge])
            wanted.push_back({edge, static_cast<std::uint8_t>(other.edge), other.triangle});
        EXPECT_EQ(triangle.beside, wanted);
      }
    };
    SCOPED_TRACE(one.name);
    const auto terrain = to_terrain(std::make_shared<const PointTerrain>(one.terrain));
    expect_model(terrain);
    for (const TerrainModel model : kBuiltTerrainModels) {
      if (!is_of_any_points(model)) continue;
      SCOPED_TRACE(name_of(model));
      const auto built =
          BuiltTerrain::build(one.terrain, {.model = model, .levels = {4, 2}}, progress);
      ASSERT_TRUE(built) << built.error().message;
      expect_model(built->terrain());
    }
  }
}

TEST(terrain_neighbours, are_of_all_triangles_that_hold_a_place_on_edges_and_corners) {
  const HeightGrid grid = neighbour_grid();
  const TerrainTin tin = triangles_of(grid, {.max_error = 0});
  // At full resolution an inner sample has 4 to 8 triangles, and the middle of a cell two, or one.
  for (const auto& [x, y] : {std::pair{20, 20}, {5, 4}, {33, 17}}) {
    const auto answers = neighbours_of(
        tin, {grid.world(x, y), grid.world(x + 0.5, y), grid.world(x + 0.3, y + 0.1)}, 0);
    EXPECT_GE(answers[0].triangles.size(), 4U);
    for (const TerrainTriangle& one : answers[0].triangles)
      EXPECT_TRUE(std::ranges::any_of(one.corners, [&](const Vec3d& p) {
        const Place at = grid.world(x, y);
        return p == Vec3d{{at[0], at[1], grid.height(x, y)}};
      }));
    EXPECT_EQ(answers[1].triangles.size(), 2U);
    EXPECT_EQ(answers[2].triangles.size(), 1U);
  }
  const auto off = neighbours_of(tin, {grid.world(14, 9), grid.world(-3, 9)}, 4);
  EXPECT_EQ(off[0].where, TerrainHeight::Where::gap);
  EXPECT_EQ(off[1].where, TerrainHeight::Where::outside);
  EXPECT_TRUE(off[0].triangles.empty() && off[1].triangles.empty());
}

TEST(terrain_neighbours, hold_everywhere_where_all_samples_are_at_hand) {
  const auto grid = std::make_shared<const HeightGrid>(neighbour_grid());
  Progress progress;
  for (const TerrainModel model :
       {TerrainModel::surface_quadtree, TerrainModel::right_triangle_bisection}) {
    const auto built = BuiltTerrain::build(*grid, {.model = model}, progress);
    ASSERT_TRUE(built);
    const TerrainTin at_samples = triangles_of(built->terrain(), {.max_error = 6});
    const TerrainTin everywhere = triangles_of(built->terrain(), {.max_error = 6, .samples = grid});
    EXPECT_TRUE(everywhere.report().is_everywhere);
    const std::vector<Place> places{grid->world(20.3, 14.9)};
    const auto less = neighbours_of(at_samples, places, 5).front().triangles;
    const auto more = neighbours_of(everywhere, places, 5).front().triangles;
    ASSERT_EQ(less.size(), more.size());
    bool is_larger = false;
    for (std::size_t i = 0; i < less.size(); ++i) {
      EXPECT_LE(less[i].bound, more[i].bound);
      is_larger = is_larger || less[i].bound < more[i].bound;
    }
    EXPECT_TRUE(is_larger);
  }
}

TEST(terrain_neighbours, do_not_where_a_last_column_has_other_heights_than_the_first) {
  const HorizontalMetric metric{
      .is_known = true, .ellipsoid = kWgs84Ellipsoid, .angle_unit = std::numbers::pi / 180};
  HeightGrid grid = test::float_grid(
      37, 20, [](int x, int y) { return (x * 5 + y * 3) % 7 + (x == 36 ? 1000 : 0); });
  grid.to_world = {-180, 10, 0, 90, 0, -9};
  const TerrainTin tin = triangles_of(Terrain(grid), {.max_error = 0.5}, metric);
  const auto found = neighbours_of(tin, {{{-180, 1}}}, 1).front().triangles;
  ASSERT_FALSE(found.empty());
  for (const TerrainTriangle& one : found) EXPECT_LT(middle_of(one.corners)[0], 0);
}

TEST(terrain_neighbours, lie_on_both_sides_of_the_seam_of_what_goes_round) {
  const HorizontalMetric metric{
      .is_known = true, .ellipsoid = kWgs84Ellipsoid, .angle_unit = std::numbers::pi / 180};
  constexpr std::int32_t kColumns = 36;
  HeightGrid open = test::float_grid(kColumns, 20, [](int x, int y) {
    return 50 * std::sin(x * std::numbers::pi / 9) * std::cos(0.3 * y) + (x * 5 + y * 3) % 7;
  });
  open.to_world = {-180, 10, 0, 90, 0, -9};
  const HeightGrid grid = cut_open_at(open, kColumns, -180);
  Progress progress;
  const TerrainOptions options{.max_error = 3};
  const auto expect_seam = [&](const Terrain& terrain) {
    const TerrainTin tin = triangles_of(terrain, options, metric);
    const auto triangles = every_triangle(terrain, options, tin);
    const auto mesh = terrain.origin().select(options, delaunay::TinLinks::left_out, progress);
    ASSERT_TRUE(mesh);
    const test::EdgePairs pairs = test::pair_by_trying(mesh->tin, kColumns);
    std::size_t n_across = 0;
    for (const TerrainTriangle& one : triangles) {
      std::vector<std::uint32_t> beside;
      std::vector<std::uint32_t> wanted;
      for (const auto& other : one.beside) beside.push_back(other.triangle);
      for (const auto& of_edge : pairs[one.triangle])
        for (const test::PairedEdge& other : of_edge) wanted.push_back(other.triangle);
      std::ranges::sort(beside);
      std::ranges::sort(wanted);
      EXPECT_EQ(beside, wanted);
      for (const std::uint32_t other : beside)
        n_across +=
            middle_of(triangles[other].corners)[0] - middle_of(one.corners)[0] > 180 ? 1 : 0;
    }
    EXPECT_GT(n_across, 3U);
    // Either name of a place on the seam has the triangles of both sides.
    const auto answers = neighbours_of(tin, {{{-180, 40.5}}, {{180, 40.5}}, {{540, 40.5}}}, 0);
    std::array<std::size_t, 2> n_sides{};
    for (const TerrainTriangle& one : answers[0].triangles)
      ++n_sides[middle_of(one.corners)[0] < 0 ? 0 : 1];
    EXPECT_GT(n_sides[0], 0U);
    EXPECT_GT(n_sides[1], 0U);
    for (const auto& answer : answers) {
      ASSERT_EQ(answer.triangles.size(), answers[0].triangles.size());
      for (std::size_t i = 0; i < answer.triangles.size(); ++i)
        EXPECT_EQ(answer.triangles[i].triangle, answers[0].triangles[i].triangle);
    }
  };
  expect_seam(grid);
  for (const TerrainModel model :
       {TerrainModel::delaunay_pyramid, TerrainModel::surface_quadtree}) {
    const auto built = BuiltTerrain::build(grid, {.model = model}, progress);
    ASSERT_TRUE(built);
    expect_seam(built->terrain());
  }
}

TEST(terrain_neighbours, are_the_same_for_any_number_of_threads_and_stop) {
  const HeightGrid grid = neighbour_grid();
  const TerrainTin tin = triangles_of(grid, {.max_error = 3});
  std::vector<Place> places;
  for (int i = 0; i < 400; ++i) places.push_back(grid.world(0.1 * i, 0.08 * i));
  const auto one = neighbours_of(tin, places, 2, 1);
  const auto two = neighbours_of(tin, places, 2, 4);
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_EQ(one[i].where, two[i].where);
    ASSERT_EQ(one[i].triangles.size(), two[i].triangles.size());
    for (std::size_t k = 0; k < one[i].triangles.size(); ++k) {
      EXPECT_EQ(one[i].triangles[k].triangle, two[i].triangles[k].triangle);
      EXPECT_EQ(one[i].triangles[k].beside, two[i].triangles[k].beside);
    }
  }
  Progress progress;
  progress.cancel();
  std::vector<TerrainNeighbours> answers;
  EXPECT_FALSE(tin.neighbours(places, {.n_rings = 2}, answers, progress));
}

TEST(terrain_neighbours, are_refused_where_answers_would_fill_memory) {
  const HeightGrid grid = neighbour_grid();
  const TerrainTin tin = triangles_of(grid, {.max_error = 0});
  const std::vector<Place> places(10, grid.world(20.2, 20.1));
  Progress progress;
  std::vector<TerrainNeighbours> answers;
  NeighboursOptions options{.n_rings = std::numeric_limits<std::uint32_t>::max()};
  const auto all = tin.neighbours(places, options, answers, progress);
  ASSERT_TRUE(all);
  EXPECT_EQ(all->n_triangles, 10 * tin.report().triangles);
  options.most_triangles = all->n_triangles;
  EXPECT_TRUE(tin.neighbours(places, options, answers, progress));
  --options.most_triangles;
  const auto report = tin.neighbours(places, options, answers, progress);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("rings"), std::string::npos) << report.error().message;
}

}  // namespace
}  // namespace lode
