// Full resolution in the style of cubes: the tetrahedra's topology on the vertices of grid edges.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <set>

#include "lode/api/dataset.h"
#include "lode/mappers/self_intersections.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/cell_field.h"
#include "lode/models/diamond/cube_meter.h"
#include "lode/models/diamond/level_set_check.h"
#include "tests/models/all_targets.h"
#include "tests/models/cube_fixtures.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using test::dataset_of;
using test::pieces_of;
using test::styled;

enum class HasGradients : std::uint8_t { no, yes };

void expect_topology_of_tetrahedra(const Volume& volume, double isovalue,
                                   HasGradients has_gradients) {
  const Dataset dataset = dataset_of(volume);
  const Surface tetra = styled(dataset, isovalue, SurfaceStyle::tetra, Normals::on);
  const Surface cubes = styled(dataset, isovalue, SurfaceStyle::cubes, Normals::on);
  const TopologyReport expected = check_topology(tetra, {});
  const TopologyReport found = check_topology(cubes, {});
  ASSERT_TRUE(found.is_clean_manifold());
  EXPECT_EQ(found.euler_number, expected.euler_number);
  EXPECT_EQ(pieces_of(found), pieces_of(expected));
  Progress progress;
  EXPECT_EQ(check_self_intersections(cubes, {1}, progress)->n_intersections, 0U);

  // Where the gradient is zero a normal is that of the vertex's triangles.
  const auto normal = [&](const Surface& surface, std::size_t v) {
    return has_gradients == HasGradients::yes ? surface.normals[v].v : std::array<float, 3>{};
  };
  std::set<std::pair<std::array<float, 3>, std::array<float, 3>>> vertices;
  for (std::size_t v = 0; v < tetra.positions.size(); ++v)
    vertices.emplace(tetra.positions[v].v, normal(tetra, v));
  for (std::size_t v = 0; v < cubes.positions.size(); ++v)
    EXPECT_TRUE(vertices.contains({cubes.positions[v].v, normal(cubes, v)})) << "vertex " << v;
}

class cube_style_shapes : public testing::TestWithParam<Index3> {};

TEST_P(cube_style_shapes, has_the_tetrahedra_s_topology_and_some_of_their_vertices_on_noise) {
  for (const bool is_mirrored : {false, true})
    for (const std::uint32_t n_values : {2U, 3U, 1000U}) {
      RegularGrid grid;
      grid.dims = GetParam();
      grid.spacing = {{0.5, 1.0, 0.75}};
      grid.origin = {{-3, 2, 1}};
      if (is_mirrored) {
        grid.direction = {{Vec3d{{0, 1, 0}}, Vec3d{{1, 0, 0}}, Vec3d{{0, 0, 1}}}};
        grid.origin = {{1000, -900, 950}};  // where float32 is coarse, and the margin large
      }
      // Few values: samples equal the isovalue, and vertices lie next to them.
      std::mt19937 random(n_values);
      const Volume volume = oracles::volume_of<float>(
          grid, [&](const Index3&) { return static_cast<double>(random() % n_values); });
      SCOPED_TRACE(n_values);
      if (n_values == 1000)
        expect_topology_of_tetrahedra(volume, 500.5, HasGradients::yes);
      else
        expect_topology_of_tetrahedra(volume, 1, HasGradients::no);
    }
}

INSTANTIATE_TEST_SUITE_P(dims, cube_style_shapes,
                         testing::Values(Index3{{2, 2, 2}}, Index3{{3, 3, 3}}, Index3{{2, 30, 2}},
                                         Index3{{32, 5, 6}}, Index3{{33, 7, 4}},
                                         Index3{{34, 33, 5}}, Index3{{5, 34, 33}},
                                         Index3{{65, 4, 34}}, Index3{{20, 21, 22}}));

TEST(cube_style, has_the_tetrahedra_s_topology_on_many_small_volumes) {
  std::mt19937 random(2026);
  for (int i = 0; i < oracles::trials(1000, 300); ++i) {
    SCOPED_TRACE(i);
    RegularGrid grid;
    for (std::size_t axis = 0; axis < 3; ++axis)
      grid.dims[axis] = 2 + static_cast<std::int32_t>(random() % 4);
    const Volume volume = oracles::volume_of<float>(
        grid, [&](const Index3&) { return static_cast<double>(random() % 4); });
    expect_topology_of_tetrahedra(volume, 2, HasGradients::no);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(cube_style, has_a_third_of_the_triangles_where_the_field_is_smooth) {
  RegularGrid grid;
  grid.dims = {{61, 62, 63}};
  const Volume volume = oracles::volume_of<float>(
      grid, [](const Index3& p) { return std::hypot(p[0] - 30.3, p[1] - 31.2, p[2] - 30.9); });
  const Dataset dataset = dataset_of(volume);
  const auto tetra = styled(dataset, 20.1, SurfaceStyle::tetra).triangles.size();
  const auto cubes = styled(dataset, 20.1, SurfaceStyle::cubes).triangles.size();
  EXPECT_NEAR(static_cast<double>(tetra) / static_cast<double>(cubes), 3, 0.1);
}

/// What style cubes gives at a tolerance, against all tetrahedra. Returns the share of their
/// triangles.
double expect_within(const Volume& volume, double isovalue, double max_error) {
  SCOPED_TRACE(max_error);
  const Dataset dataset = dataset_of(volume);
  ExtractOptions options{.isovalues = {isovalue},
                         .max_error = max_error,
                         .style = SurfaceStyle::cubes,
                         .deviation = Deviation::measured,
                         .threads = {2}};
  Progress progress;
  Surface cubes;
  const auto report = dataset.extract(options, cubes, progress);
  if (!report) {
    ADD_FAILURE() << report.error().message;
    return 0;
  }
  if (max_error > 0) EXPECT_LE(report->style_error, max_error);
  const TopologyReport found = check_topology(cubes, {});
  EXPECT_TRUE(found.is_clean_manifold());
  EXPECT_EQ(check_self_intersections(cubes, {2}, progress)->n_intersections, 0U);
  const auto level_set = diamond::check_level_set(
      diamond::VolumeSamples(volume), cubes, {.isovalues = {isovalue}, .threads = {1}}, progress);
  EXPECT_LE(level_set->max_deviation,
            std::max(report->style_error, report->achieved_error) + report->coordinate_slack);
  EXPECT_TRUE(dataset.verify_surface(cubes, options, progress)->passed());

  options.style = SurfaceStyle::tetra;
  options.max_error = 0.0;
  Surface tetra;
  EXPECT_TRUE(dataset.extract(options, tetra, progress));
  const TopologyReport expected = check_topology(tetra, {});
  EXPECT_EQ(found.euler_number, expected.euler_number);
  EXPECT_EQ(pieces_of(found), pieces_of(expected));
  return static_cast<double>(cubes.triangles.size()) / static_cast<double>(tetra.triangles.size());
}

TEST(cube_style, falls_back_to_tetrahedra_where_a_bound_would_break) {
  RegularGrid grid;
  grid.dims = {{61, 62, 40}};
  grid.spacing = {{0.5, 1.0, 0.75}};
  const Volume sphere = oracles::volume_of<float>(grid, [](const Index3& p) {
    return std::hypot(p[0] - 30.3, p[1] - 31.2, p[2] - 30.9) + 0.1 * std::sin(0.6 * p[0] + p[1]);
  });
  std::vector<double> shares;
  for (const double max_error : {0.0, 0.3, 0.1, 0.03, 0.01, 0.001})
    shares.push_back(expect_within(sphere, 20.1, max_error));
  EXPECT_NEAR(shares[0], 1 / 3.0, 0.03);
  EXPECT_NEAR(shares[1], 1 / 3.0, 0.03);
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_LT(shares[3], 0.9);
  EXPECT_GT(shares.back(), 0.95);
}

TEST(cube_style, falls_back_on_noise) {
  for (const Index3& dims :
       {Index3{{9, 8, 7}}, oracles::trials<Index3>({{34, 35, 12}}, {{34, 35, 4}}),
        oracles::trials<Index3>({{66, 6, 33}}, {{66, 3, 33}})})
    for (const std::uint32_t n_values : {3U, 1000U}) {
      SCOPED_TRACE(n_values);
      RegularGrid grid;
      grid.dims = dims;
      grid.direction = {{Vec3d{{0, 1, 0}}, Vec3d{{1, 0, 0}}, Vec3d{{0, 0, 1}}}};
      std::mt19937 random(n_values);
      const Volume volume = oracles::volume_of<float>(
          grid, [&](const Index3&) { return static_cast<double>(random() % n_values); });
      for (const double share :
           oracles::trials<std::vector<double>>({0.01, 0.1, 0.2, 0.3, 0.5}, {0.01, 0.2, 0.5}))
        expect_within(volume, n_values / 2.0 + 0.5, share * n_values);
    }
}

TEST(cube_style, falls_back_on_many_small_volumes) {
  std::mt19937 random(2027);
  for (int i = 0; i < oracles::trials(500, 200); ++i) {
    SCOPED_TRACE(i);
    RegularGrid grid;
    for (std::size_t axis = 0; axis < 3; ++axis)
      grid.dims[axis] = 2 + static_cast<std::int32_t>(random() % 5);
    const Volume volume = oracles::volume_of<float>(
        grid, [&](const Index3&) { return static_cast<double>(random() % 4); });
    expect_within(volume, 2, 0.25 * static_cast<double>(1 + random() % 6));
    if (testing::Test::HasFailure()) return;
  }
}

TEST(cube_style, leaves_bricks_with_holes_to_tetrahedra) {
  RegularGrid grid;
  grid.dims = {{70, 40, 36}};
  const Volume volume = oracles::volume_of<float>(grid, [](const Index3& p) {
    const bool is_hole = p[0] < 5 && p[1] > 20 && p[2] > 12;
    return is_hole ? std::nan("") : std::hypot(p[0] - 40.3, p[1] - 21.2, p[2] - 20.9);
  });
  EXPECT_LT(expect_within(volume, 14.1, 0), 0.8);
  EXPECT_LT(expect_within(volume, 14.1, 0.1), 0.9);
  expect_within(volume, 36.1, 0.02);
}

TEST(cube_style, is_of_volumes) {
  RegularGrid flat;
  flat.dims = {{5, 6, 1}};
  Progress progress;
  Surface surface;
  EXPECT_FALSE(dataset_of(oracles::volume_of<float>(flat, [](const Index3& p) {
                 return static_cast<double>(p[0]);
               })).extract({.isovalues = {2.5}, .style = SurfaceStyle::cubes}, surface, progress));
}

double distance_to_triangle(const Vec3d& p, const std::array<Vec3d, 3>& t) {
  // Of points of a fine grid on it: at most half its spacing more.
  constexpr int kSteps = 24;
  double nearest = 1e9;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j)
      nearest = std::min(nearest, length(t[0] + (t[1] - t[0]) * (i / double{kSteps}) +
                                         (t[2] - t[0]) * (j / double{kSteps}) - p));
  return nearest;
}

std::vector<std::array<Vec3d, 3>> corners_of(const Surface& surface) {
  std::vector<std::array<Vec3d, 3>> corners;
  for (const auto& t : surface.triangles)
    corners.push_back(
        {surface.world_position(t[0]), surface.world_position(t[1]), surface.world_position(t[2])});
  return corners;
}

TEST(cube_style, measures_how_far_it_is_from_the_level_set) {
  RegularGrid grid;
  grid.dims = {{4, 5, 4}};
  grid.spacing = {{1, 0.75, 1.25}};
  for (std::uint32_t seed = 1; seed <= oracles::trials(3U, 1U); ++seed) {
    oracles::Random random(seed);
    const Volume volume =
        oracles::volume_of<float>(grid, [&](const Index3&) { return random.uniform(-1, 1); });
    const Dataset dataset = dataset_of(volume);
    Progress progress;
    Surface cubes;
    const ExtractOptions options{.isovalues = {0.1},
                                 .max_error = 0.0,
                                 .style = SurfaceStyle::cubes,
                                 .deviation = Deviation::measured,
                                 .threads = {2}};
    const auto report = dataset.extract(options, cubes, progress);
    ASSERT_TRUE(report);
    // Another way to the same number, from the written triangles.
    const auto level_set = diamond::check_level_set(diamond::VolumeSamples(volume), cubes,
                                                    {.isovalues = {0.1}, .threads = {1}}, progress);
    ASSERT_TRUE(level_set);
    EXPECT_NEAR(level_set->max_deviation, report->style_error, report->coordinate_slack);
    EXPECT_TRUE(dataset.verify_surface(cubes, options, progress)->passed());

    const auto exact = corners_of(styled(dataset, 0.1, SurfaceStyle::tetra));
    double farthest = 0;
    for (const auto& t : corners_of(cubes))
      for (const Vec3d& weights : {Vec3d{{1, 1, 1}}, Vec3d{{2, 1, 0}}, Vec3d{{0, 1, 1}},
                                   Vec3d{{1, 0, 2}}, Vec3d{{3, 1, 1}}, Vec3d{{1, 3, 1}}}) {
        const Vec3d p = (t[0] * weights[0] + t[1] * weights[1] + t[2] * weights[2]) *
                        (1 / (weights[0] + weights[1] + weights[2]));
        double nearest = 1e9;
        for (const auto& u : exact) nearest = std::min(nearest, distance_to_triangle(p, u));
        farthest = std::max(farthest, nearest);
      }
    constexpr double kSpacing = 0.08;  // of the grids of points on triangles of up to 1.8
    EXPECT_LE(farthest, report->style_distance + kSpacing / 2);
    EXPECT_GE(farthest, report->style_distance / 3);
    EXPECT_LT(report->style_distance, length(grid.spacing));
  }
}

/// Of two cells beside each other, which share no sample, at x = 500.
diamond::CubeDeviation deviation_of_cells(const std::array<std::array<float, 8>, 2>& cells,
                                          double isovalue, std::vector<std::int32_t> order) {
  RegularGrid grid;
  grid.dims = {{4, 2, 2}};
  const Volume volume = oracles::volume_of<float>(grid, [&](const Index3& p) {
    const auto& cell = cells[static_cast<std::size_t>(p[0] / 2)];
    return static_cast<double>(cell[static_cast<std::size_t>(p[0] % 2 + 2 * p[1] + 4 * p[2])]);
  });
  RegularGrid far;
  far.dims = {{16, 16, 16}};
  far.origin = {{500, 0, 0}};
  diamond::CubeMeter meter(LatticeFrame::of(far), isovalue);
  const diamond::VolumeSamples samples(volume);
  for (const std::int32_t i : order) meter.add(samples, {{2 * i, 0, 0}});
  return meter.deviation();
}

TEST(cube_style, is_as_far_from_the_level_set_whatever_cell_is_measured_first) {
  const std::array<std::array<float, 8>, 2> known{
      {{9, 12, 14, 3, 10, 1, 13, 1}, {15, 4, 7, 8, 12, 8, 0, 3}}};
  const auto expect_any_order = [](const auto& cells, double isovalue) {
    const auto both = deviation_of_cells(cells, isovalue, {0, 1});
    const auto turned = deviation_of_cells(cells, isovalue, {1, 0});
    EXPECT_EQ(both.distance, turned.distance);
    EXPECT_EQ(both.error, turned.error);
    // Whatever is not looked at in a cell as it cannot be the largest.
    EXPECT_EQ(both.error, std::max(deviation_of_cells(cells, isovalue, {0}).error,
                                   deviation_of_cells(cells, isovalue, {1}).error));
  };
  expect_any_order(known, 8);
  std::mt19937 random(6);
  for (int i = 0; i < 5000; ++i) {
    std::array<std::array<float, 8>, 2> cells;
    for (auto& cell : cells)
      for (float& value : cell) value = static_cast<float>(random() % 5);
    expect_any_order(cells, 2);
    // One that is nearly linear.
    for (std::size_t k = 0; k < 8; ++k) {
      const auto sum = static_cast<float>((k & 1) * 3 + (k >> 1 & 1) * 2 + (k >> 2));
      cells[0][k] = sum + 0.1F * cells[0][k];
    }
    expect_any_order(cells, 2);
  }
}

/// Noise along some rows, waves elsewhere: full words of crossed edges, and single ones.
template <typename T>
void expect_same_bytes(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{0.5, 1.25, 0.75}};
  oracles::Random random(11);
  const Dataset dataset = dataset_of(oracles::volume_of<T>(grid, [&](const Index3& p) {
    if (p[1] % 5 == 0) return random.uniform(0, 200);
    return 100 + 60 * std::sin(0.2 * p[0]) * std::cos(0.3 * p[1] + 0.1 * p[2]);
  }));
  const Surface expected = styled(dataset, 90.5, SurfaceStyle::cubes, Normals::on, 1);
  EXPECT_FALSE(expected.is_empty());
  test::for_each_target([&] {
    for (const int threads : {1, 2, 3}) {
      const Surface surface = styled(dataset, 90.5, SurfaceStyle::cubes, Normals::on, threads);
      EXPECT_TRUE(surface.positions == expected.positions);
      EXPECT_TRUE(surface.triangles == expected.triangles);
      EXPECT_TRUE(surface.normals == expected.normals);
    }
  });
}

TEST(cube_style, has_the_same_bytes_with_every_kind_of_vector_and_any_threads) {
  for (const Index3& dims :
       {Index3{{33, 40, 20}}, Index3{{70, 41, 9}}, Index3{{257, 34, 5}}, Index3{{600, 7, 6}}}) {
    SCOPED_TRACE(dims[0]);
    expect_same_bytes<std::uint8_t>(dims);
    expect_same_bytes<std::uint16_t>(dims);
    expect_same_bytes<std::int16_t>(dims);
    expect_same_bytes<float>(dims);
    expect_same_bytes<double>(dims);
  }
}

/// From each vertex of one surface to the other.
double farthest_vertex(const Surface& from, const Surface& to) {
  const std::vector<std::array<Vec3d, 3>> triangles = corners_of(to);
  double farthest = 0;
  for (std::size_t v = 0; v < from.positions.size(); ++v) {
    const Vec3d p = from.world_position(static_cast<std::uint32_t>(v));
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& t : triangles) nearest = std::min(nearest, distance_to_triangle(p, t));
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

/// Points of the level set may be farther from cubes than any of theirs is from it.
TEST(cube_style, verification_says_how_far_cubes_and_the_level_set_are_apart) {
  RegularGrid grid;
  grid.dims = {{5, 4, 4}};
  grid.spacing = {{0.5, 1, 0.75}};
  std::mt19937 random(4);
  const Volume volume = oracles::volume_of<float>(
      grid, [&](const Index3&) { return static_cast<double>(random() % 4); });
  const Dataset dataset = dataset_of(volume);
  const Surface tetra = styled(dataset, 1.5, SurfaceStyle::tetra, Normals::off);
  for (const Simplify simplify : {Simplify::off, Simplify::edges}) {
    ExtractOptions options{.isovalues = {1.5}, .max_error = 0, .style = SurfaceStyle::cubes};
    options.simplify = simplify;
    if (simplify != Simplify::off) options.simplify_distance = 0.4;
    Progress progress;
    Surface surface;
    ASSERT_TRUE(dataset.extract(options, surface, progress));
    const auto report = dataset.verify_surface(surface, options, progress);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->passed());
    const auto check = std::ranges::find(report->checks,
                                         "distance from the level set at full "
                                         "resolution and back",
                                         &VerifyReport::Check::name);
    ASSERT_NE(check, report->checks.end());
    double there = 0;
    double back = 0;
    double there_at_most = 0;
    double back_at_most = 0;
    ASSERT_EQ(std::sscanf(check->detail.c_str(), "measured %lf and %lf, at most %lf and %lf",
                          &there, &back, &there_at_most, &back_at_most),
              4);
    constexpr double kGrid = 0.05;  // of distance_to_triangle()
    EXPECT_LE(farthest_vertex(surface, tetra), there_at_most + kGrid);
    EXPECT_LE(farthest_vertex(tetra, surface), back_at_most + kGrid);
    EXPECT_GE(farthest_vertex(tetra, surface), 0.5 * back);
    EXPECT_LE(there, there_at_most);
    EXPECT_LE(there_at_most - there, 0.5 / 16);
    EXPECT_LE(back_at_most - back, 0.5 / 16);
    EXPECT_GT(back, 0.3);
  }
}

/// Whatever else is found: cubes of isovalues near each other may meet.
VerifyReport::Check level_set_check(const Dataset& dataset, const ExtractOptions& options) {
  Progress progress;
  Surface surface;
  EXPECT_TRUE(dataset.extract(options, surface, progress));
  const auto report = dataset.verify_surface(surface, options, progress);
  EXPECT_TRUE(report);
  for (const VerifyReport::Check& check : report->checks)
    if (check.name.starts_with("distance from the level set")) return check;
  return {};
}

Dataset noise_of_hundred_values() {
  RegularGrid grid;
  grid.dims = {{9, 8, 7}};
  std::mt19937 random(5);
  return dataset_of(oracles::volume_of<float>(
      grid, [&](const Index3&) { return static_cast<double>(random() % 100); }));
}

/// What is near may be of another isovalue.
TEST(cube_style, verification_measures_the_distance_of_each_isovalue_by_itself) {
  const Dataset dataset = noise_of_hundred_values();
  const auto measured = [&](const std::vector<double>& isovalues) {
    const auto check = level_set_check(
        dataset, {.isovalues = isovalues, .max_error = 0, .style = SurfaceStyle::cubes});
    std::array<double, 2> ways{};
    EXPECT_EQ(std::sscanf(check.detail.c_str(), "measured %lf and %lf", &ways[0], &ways[1]), 2);
    return ways;
  };
  const auto lower = measured({50.5});
  const auto higher = measured({60.5});
  const auto both = measured({50.5, 60.5});
  for (std::size_t way = 0; way < 2; ++way)
    EXPECT_NEAR(both[way], std::max(lower[way], higher[way]), 1e-9);
}

TEST(cube_style, verification_says_where_it_does_not_measure_the_distance) {
  const Dataset dataset = noise_of_hundred_values();
  ExtractOptions options{.isovalues = {90.5}, .max_error = 0, .style = SurfaceStyle::cubes};
  EXPECT_FALSE(level_set_check(dataset, options).skipped);
  options.min_component = 40;
  EXPECT_TRUE(level_set_check(dataset, options).skipped);
  options.min_component = 0;
  options.max_error = 20;
  EXPECT_TRUE(level_set_check(dataset, options).skipped);
}

}  // namespace
}  // namespace lode
