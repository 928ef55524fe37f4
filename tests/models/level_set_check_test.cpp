#include "lode/models/diamond/level_set_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <span>

#include "lode/mappers/surface_checks.h"
#include "tests/models/finest_level_set.h"

namespace lode::diamond {
namespace {

using test::field_at;
using test::finest_level_set;
using test::random_volume;

RegularGrid small_grid(std::int32_t x, std::int32_t y, std::int32_t z) {
  RegularGrid grid;
  grid.dims = {{x, y, z}};
  return grid;
}

/// Rotated, mirrored, unequal steps, off the origin.
RegularGrid skewed(RegularGrid grid) {
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  grid.direction = {{Vec3d{{c, s, 0}}, Vec3d{{s, -c, 0}}, Vec3d{{0, 0, 1}}}};
  grid.spacing = {{0.5, 0.25, 2.0}};
  grid.origin = {{3, -2, 1}};
  return grid;
}

LevelSetReport report_of(const Volume& volume, const Surface& surface, LevelSetOptions options) {
  Progress progress;
  const VolumeSamples samples(volume);
  auto report = check_level_set(samples, surface, options, progress);
  EXPECT_TRUE(report);
  return *report;
}

// Values differ by at most 2 across a cell, so F's slope is at most 2 per axis and index unit.
// Clamping the edge parameter to 1e-3 from the ends moves F by at most 2e-3 · 2.
constexpr double kOracleSlack = 4e-3;

class level_set_check : public testing::TestWithParam<RegularGrid> {};

TEST_P(level_set_check, accepts_the_exact_level_set) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const Volume volume = random_volume(GetParam(), seed);
    const Surface surface = finest_level_set(volume, 0.1);
    ASSERT_FALSE(surface.is_empty());
    const auto report =
        report_of(volume, surface, {.isovalues = {0.1}, .tolerance = kOracleSlack, .clip = {}});
    EXPECT_TRUE(report.holds()) << "seed " << seed << ": " << report.max_deviation;
    EXPECT_GE(report.n_pieces, report.n_simplices);
    const auto topology = check_topology(surface, {.threads = {2}});
    EXPECT_EQ(topology.non_manifold_edges.count + topology.non_manifold_vertices.count +
                  topology.degenerate_simplices.count + topology.duplicate_vertices.count,
              0U);
    if (!surface.triangles.empty()) EXPECT_EQ(topology.inconsistent_edges.count, 0U);
    Progress progress;
    const auto crossings = check_self_intersections(surface, {2}, progress);
    ASSERT_TRUE(crossings);
    EXPECT_EQ(crossings->n_intersections, 0U);
  }
}

TEST_P(level_set_check, detects_a_vertex_that_moved) {
  const Volume volume = random_volume(GetParam(), 3);
  Surface surface = finest_level_set(volume, 0.0);
  std::mt19937 random(4);
  int n_detected = 0;
  const int n_trials = 50;
  for (int trial = 0; trial < n_trials; ++trial) {
    Surface moved = surface;
    const auto v = random() % moved.positions.size();
    // A tenth of a cell towards the middle of the grid.
    const Vec3d index = GetParam().to_index(moved.world_position(static_cast<std::uint32_t>(v)));
    Vec3d target = index;
    for (std::size_t i = 0; i < 3; ++i)
      target[i] += 2 * index[i] < GetParam().dims[i] - 1 ? 0.1 : -0.1;
    for (std::size_t i = 0; i < 3; ++i)
      if (GetParam().dims[i] == 1) target[i] = 0;
    const Vec3d world = GetParam().to_world(target);
    for (std::size_t i = 0; i < 3; ++i) moved.positions[v][i] = static_cast<float>(world[i]);
    const auto report =
        report_of(volume, moved, {.isovalues = {0.0}, .tolerance = kOracleSlack, .clip = {}});
    n_detected += report.beyond_tolerance.count > 0 ? 1 : 0;
  }
  EXPECT_GE(n_detected, n_trials * 9 / 10) << "only moves along the level set stay unseen";
}

TEST_P(level_set_check, finds_the_largest_deviation_of_large_simplices) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const RegularGrid& grid = GetParam();
  const bool is_flat = std::min({grid.dims[0], grid.dims[1], grid.dims[2]}) == 1;
  const std::size_t n_corners = is_flat ? 2 : 3;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    const Volume volume = random_volume(grid, seed);
    Surface surface;
    for (std::size_t k = 0; k < n_corners; ++k) {
      Vec3d index;
      for (std::size_t i = 0; i < 3; ++i) index[i] = unit(random) * (grid.dims[i] - 1);
      const Vec3d world = grid.to_world(index);
      surface.positions.push_back({{static_cast<float>(world[0]), static_cast<float>(world[1]),
                                    static_cast<float>(world[2])}});
    }
    if (is_flat)
      surface.lines = {{0, 1}};
    else
      surface.triangles = {{0, 1, 2}};
    const auto report =
        report_of(volume, surface, {.isovalues = {0.2}, .tolerance = 0, .clip = {}});
    const auto deviation_at = [&](const Vec3d& world) {
      Vec3d x = grid.to_index(world);
      for (std::size_t i = 0; i < 3; ++i) x[i] = std::clamp(x[i], 0.0, grid.dims[i] - 1.0);
      return std::abs(field_at(volume, x) - 0.2);
    };
    // Attained there, up to double rounding, and nowhere exceeded.
    EXPECT_NEAR(deviation_at(report.worst_point), report.max_deviation, 1e-11);
    double sampled = 0;
    for (int n = 0; n < 20000; ++n) {
      double s = unit(random);
      double t = is_flat ? 0 : unit(random);
      if (s + t > 1) {
        s = 1 - s;
        t = 1 - t;
      }
      const Vec3d a = surface.world_position(0);
      const Vec3d p = a + (surface.world_position(1) - a) * s +
                      (surface.world_position(is_flat ? 0 : 2) - a) * t;
      sampled = std::max(sampled, deviation_at(p));
    }
    EXPECT_LE(sampled, report.max_deviation + 1e-11) << "seed " << seed;
    EXPECT_GE(sampled, 0.85 * report.max_deviation) << "seed " << seed;
    EXPECT_EQ(report.beyond_tolerance.count, 1U);
  }
}

INSTANTIATE_TEST_SUITE_P(grids, level_set_check,
                         testing::Values(small_grid(6, 5, 7), skewed(small_grid(7, 8, 4)),
                                         small_grid(2, 30, 2), small_grid(9, 12, 1),
                                         small_grid(9, 1, 8), skewed(small_grid(1, 7, 9))));

TEST(level_set_check_rules, are_the_same_for_any_threads) {
  const Volume volume = random_volume(small_grid(20, 20, 20), 9);
  const Surface surface = finest_level_set(volume, 0.0);
  const auto one = report_of(volume, surface, {.isovalues = {0.05}, .clip = {}, .threads = {1}});
  const auto four = report_of(volume, surface, {.isovalues = {0.05}, .clip = {}, .threads = {4}});
  EXPECT_EQ(one.max_deviation, four.max_deviation);
  EXPECT_EQ(one.worst_point, four.worst_point);
  EXPECT_EQ(one.n_pieces, four.n_pieces);
  EXPECT_EQ(one.beyond_tolerance, four.beyond_tolerance);
}

TEST(level_set_check_rules, refuse_what_leaves_the_lattice_or_the_clip_box) {
  const Volume volume = random_volume(small_grid(5, 5, 5), 1);
  Surface surface;
  surface.positions = {Vec3f{{1, 1, 1}}, Vec3f{{4.001F, 1, 1}}, Vec3f{{1, 2, 1}}};
  surface.triangles = {{0, 1, 2}};
  LevelSetOptions options{.isovalues = {0}, .tolerance = 9, .clip = {}};
  EXPECT_EQ(report_of(volume, surface, options).outside.count, 1U);
  surface.positions[1][0] = 4.0F;
  EXPECT_TRUE(report_of(volume, surface, options).holds());
  options.clip = Box3d{{{0, 0, 0}}, {{3, 3, 3}}};
  EXPECT_EQ(report_of(volume, surface, options).outside.count, 1U);
}

TEST(level_set_check_rules, keep_out_of_removed_cells_but_allow_their_border) {
  Volume volume = random_volume(small_grid(7, 7, 7), 6);
  std::vector<float> samples(volume.as<float>().begin(), volume.as<float>().end());
  samples[3 + 7 * (3 + 7 * 3)] = std::numeric_limits<float>::quiet_NaN();
  volume = make_volume<float>(volume.info.grid, samples);
  // The exact surface ends at the removed cells, and rounding there is forgiven.
  const Surface exact = finest_level_set(volume, 0.0);
  LevelSetOptions options{.isovalues = {0}, .tolerance = kOracleSlack, .clip = {}};
  EXPECT_TRUE(report_of(volume, exact, options).holds());
  options.tolerance = 9;
  Surface surface;
  surface.positions = {Vec3f{{2, 2.2F, 2.2F}}, Vec3f{{2, 2.8F, 2.2F}}, Vec3f{{2, 2.2F, 2.8F}}};
  surface.triangles = {{0, 1, 2}};
  EXPECT_TRUE(report_of(volume, surface, options).holds());
  surface.positions[0][0] = 2.01F;
  EXPECT_EQ(report_of(volume, surface, options).inside_removed.count, 1U);
  // A face between two removed cells is inside.
  for (Vec3f& p : surface.positions) p[0] = 3;
  EXPECT_EQ(report_of(volume, surface, options).inside_removed.count, 1U);
}

TEST(level_set_check_rules, choose_among_several_isovalues) {
  const Volume volume = random_volume(small_grid(6, 6, 6), 2);
  Surface surface = finest_level_set(volume, 0.1);
  surface.isovalues.assign(surface.positions.size(), 0.1F);
  const LevelSetOptions options{.isovalues = {-0.3, 0.1}, .tolerance = kOracleSlack, .clip = {}};
  EXPECT_TRUE(report_of(volume, surface, options).holds());
  surface.isovalues[surface.triangles[0][0]] = -0.3F;
  EXPECT_GT(report_of(volume, surface, options).ambiguous_isovalue.count, 0U);
}

TEST(level_set_check_rules, bound_caps_from_below_only) {
  std::vector<float> samples;
  for (int i = 0; i < 27; ++i) samples.push_back(static_cast<float>(i % 3));
  const Volume volume = make_volume<float>(small_grid(3, 3, 3), samples);
  Surface surface;
  surface.positions = {Vec3f{{1, 0, 0}}, Vec3f{{2, 0, 0}}, Vec3f{{2, 2, 0}}};
  surface.triangles = {{0, 1, 2}};
  LevelSetOptions options{.isovalues = {1}, .tolerance = 1e-6, .clip = {}};
  EXPECT_EQ(report_of(volume, surface, options).beyond_tolerance.count, 1U);
  options.caps = Caps::on_border;
  const auto report = report_of(volume, surface, options);
  EXPECT_TRUE(report.holds());
  EXPECT_EQ(report.n_caps, 1U);
  options.isovalues = {1.5};
  EXPECT_EQ(report_of(volume, surface, options).beyond_tolerance.count, 1U);
}

TEST(level_set_check_rules, stop_when_cancelled) {
  const Volume volume = random_volume(small_grid(6, 6, 6), 2);
  Progress progress;
  progress.cancel();
  const VolumeSamples samples(volume);
  EXPECT_FALSE(check_level_set(samples, finest_level_set(volume, 0), {.isovalues = {0}, .clip = {}},
                               progress));
}

}  // namespace
}  // namespace lode::diamond
