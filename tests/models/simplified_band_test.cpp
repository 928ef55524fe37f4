// Simplified within an error: what comes out is held against the field by checks of their own.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "lode/api/dataset.h"
#include "lode/mappers/surface_distance.h"
#include "lode/mappers/surface_edits.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/side_check.h"
#include "tests/models/built_dataset.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using oracles::Random;
using oracles::trials;

void expect_holds(const Result<VerifyReport>& report) {
  ASSERT_TRUE(report) << report.error().message;
  for (const VerifyReport::Check& check : report->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

struct Simplified {
  Surface surface;
  ExtractReport report;
};

Simplified simplified(const Dataset& dataset, const ExtractOptions& options) {
  Simplified found;
  Progress progress;
  auto report = dataset.extract(options, found.surface, progress);
  EXPECT_TRUE(report) << (report ? "" : report.error().message);
  if (report) found.report = *report;
  expect_holds(dataset.verify_surface(found.surface, options, progress));
  return found;
}

void expect_same(const Surface& a, const Surface& b) {
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
}

/// Blobs of noise of some size, of values round 0 between -1 and 1.
double rough(const Index3& p, std::uint64_t seed) {
  const Vec3d x{{0.4 * p[0], 0.31 * p[1], 0.37 * p[2]}};
  Random random(seed + static_cast<std::uint64_t>(p[0] + 1000 * (p[1] + 1000 * p[2])));
  return 0.7 * std::sin(x[0]) * std::cos(x[1] + 0.3) * std::sin(x[2] + 1) +
         0.3 * random.uniform(-1, 1);
}

template <typename T>
Volume rough_volume(const Index3& dims, double scale, std::uint64_t seed) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{0.7, 1, 1.6}};
  grid.origin = {{1, -20, 300}};
  return oracles::volume_of<T>(grid, [&](const Index3& p) { return scale * rough(p, seed); });
}

void expect_small_and_true(const Volume& volume, double isovalue, double error) {
  const Dataset dataset = test::built_dataset(volume);
  ExtractOptions options{.isovalues = {isovalue}, .max_error = error, .threads = {2}};
  Progress progress;
  Surface before;
  ASSERT_TRUE(dataset.extract(options, before, progress));
  options.simplify = Simplify::edges;
  const Simplified found = simplified(dataset, options);
  EXPECT_LT(found.surface.triangles.size(), before.triangles.size());
  EXPECT_LE(found.report.simplified->proven_error, error);
  EXPECT_EQ(found.report.max_error, error);
  EXPECT_LE(found.report.achieved_error, error / 2);
  options.threads = {1};
  Surface again;
  ASSERT_TRUE(dataset.extract(options, again, progress));
  expect_same(again, found.surface);
}

TEST(simplified_band, holds_on_rough_fields_of_all_types) {
  const auto integers = trials<Index3>({{40, 37, 23}}, {{40, 35, 9}});
  expect_small_and_true(rough_volume<std::int16_t>(integers, 1000, 2), 12, 100);
  expect_small_and_true(rough_volume<std::int16_t>(integers, 1000, 3), 0, 400);
  const auto floats = trials<Index3>({{37, 40, 25}}, {{13, 40, 20}});
  expect_small_and_true(rough_volume<float>(floats, 1, 4), 0.1, 0.05);
  const auto along_x = trials<Index3>({{70, 20, 21}}, {{70, 12, 13}});
  expect_small_and_true(rough_volume<float>(along_x, 1, 5), -0.1, 0.3);
  const auto along_y = trials<Index3>({{18, 67, 20}}, {{12, 67, 12}});
  expect_small_and_true(rough_volume<double>(along_y, 1e-7, 6), 1e-8, 2e-8);
}

TEST(simplified_band, and_distance_keep_the_same_triangles_whichever_way_they_face) {
  const Dataset dataset = test::built_dataset(rough_volume<float>({{24, 18, 16}}, 1, 4));
  enum class Case : std::uint8_t { error, distance, slivers };
  for (const Case which : {Case::error, Case::distance, Case::slivers}) {
    ExtractOptions options{.isovalues = {0.1}, .max_error = 0.1, .normals = Normals::on};
    options.simplify = which == Case::slivers ? Simplify::slivers : Simplify::edges;
    if (which != Case::error) {
      options.max_error = 0;
      options.simplify_distance = 0.4;
      options.min_component = 30;
    }
    Surface turned = simplified(dataset, options).surface;
    flip_orientation(turned);
    options.orientation = Orientation::from_higher_values;
    expect_same(simplified(dataset, options).surface, turned);
  }
}

TEST(simplified_band, holds_on_noise_and_of_uint8) {
  RegularGrid grid;
  grid.dims = trials<Index3>({{35, 34, 20}}, {{35, 34, 6}});
  Random random(7);
  const Volume noise =
      oracles::volume_of<std::uint8_t>(grid, [&](const Index3&) { return random.below(256); });
  expect_small_and_true(noise, 127.5, 20);
  expect_small_and_true(noise, 100, 3);  // on samples
  const Volume smooth = oracles::volume_of<std::uint8_t>(
      grid, [&](const Index3& p) { return 100 + 90 * rough(p, 8); });
  expect_small_and_true(smooth, 100.5, 10);
}

TEST(simplified_band, holds_beside_holes_and_ends_where_the_surface_did) {
  const auto dims = trials<Index3>({{40, 37, 23}}, {{40, 25, 13}});
  Volume volume = rough_volume<float>(dims, 1, 9);
  auto samples = oracles::typed_samples<float>(volume);
  Random random(10);
  for (int i = 0; i < 40; ++i)
    samples[random.below(samples.size())] = std::numeric_limits<float>::quiet_NaN();
  const auto row = static_cast<std::ptrdiff_t>(40 * dims[1] * 5 + 40 * 8);
  std::fill(samples.begin() + row, samples.begin() + row + 60,
            std::numeric_limits<float>::quiet_NaN());
  const Dataset dataset = test::built_dataset(volume);
  for (const double error : {0.1, 0.3}) {
    ExtractOptions options{.isovalues = {0.05}, .max_error = error, .threads = {2}};
    options.simplify = Simplify::edges;
    const Simplified found = simplified(dataset, options);
    EXPECT_LT(found.report.triangles, found.report.simplified->triangles_before / 2);
  }
}

TEST(simplified_band, holds_in_oblique_and_mirrored_grids_and_far_from_the_origin) {
  Volume volume = rough_volume<float>(trials<Index3>({{30, 29, 23}}, {{35, 17, 12}}), 1, 11);
  const double s = std::sqrt(0.5);
  volume.info.grid.direction = {{Vec3d{{s, s, 0}}, Vec3d{{-s, s, 0}}, Vec3d{{0, 0, 1}}}};
  expect_small_and_true(volume, 0.05, 0.2);
  volume.info.grid.direction = {{Vec3d{{0, 1, 0}}, Vec3d{{1, 0, 0}}, Vec3d{{0, 0, 1}}}};
  expect_small_and_true(volume, 0.05, 0.2);
  volume.info.grid.origin = {{5e6, -4e6, 1e5}};
  expect_small_and_true(volume, 0.05, 0.2);
  volume.info.grid.spacing = {{1e-6, 2e-6, 1e-6}};
  volume.info.grid.origin = {{0, 0, 0}};
  expect_small_and_true(volume, 0.05, 0.2);
}

TEST(simplified_band, keeps_inside_thin_oblique_grids_of_two_layers) {
  for (std::uint64_t seed = 20; seed < trials(26U, 22U); ++seed) {
    Volume volume = rough_volume<float>({{2, 34, 98}}, 1, seed);
    volume.info.grid.direction = {{Vec3d{{0.8, -0.6, 0}}, Vec3d{{0.6, 0.8, 0}}, Vec3d{{0, 0, 1}}}};
    const Dataset dataset = test::built_dataset(volume);
    for (const SurfaceStyle style : {SurfaceStyle::tetra, SurfaceStyle::cubes}) {
      ExtractOptions options{.isovalues = {0}, .max_error = 0.5, .style = style, .threads = {2}};
      options.simplify = Simplify::edges;
      static_cast<void>(simplified(dataset, options));
    }
  }
}

/// A ball of radius 8 round (16, 16, 16), 100 inside and 0 outside, with some samples changed.
Volume ball_with(const std::vector<std::pair<Index3, double>>& changes) {
  RegularGrid grid;
  grid.dims = {{33, 33, 33}};
  Volume volume = oracles::volume_of<float>(grid, [](const Index3& p) {
    const Vec3d d{{p[0] - 16.0, p[1] - 16.0, p[2] - 16.0}};
    return std::clamp(50 + 20 * (8 - length(d)), 0.0, 100.0);
  });
  auto samples = oracles::typed_samples<float>(volume);
  for (const auto& [p, value] : changes)
    samples[static_cast<std::size_t>(p[0] + 33 * (p[1] + 33 * p[2]))] = static_cast<float>(value);
  return volume;
}

Simplified of_ball(const std::vector<std::pair<Index3, double>>& changes, double error) {
  ExtractOptions options{.isovalues = {50}, .max_error = error, .threads = {2}};
  options.simplify = Simplify::edges;
  return simplified(test::built_dataset(ball_with(changes)), options);
}

TEST(simplified_band, drops_closed_components_that_hold_nothing_beyond_it) {
  // Specks of 55 and 80 outside and 45 inside, one at the border.
  const Simplified found = of_ball({{{{4, 4, 4}}, 55},
                                    {{{4, 5, 4}}, 54},
                                    {{{28, 4, 4}}, 80},
                                    {{{16, 16, 16}}, 45},
                                    {{{0, 28, 20}}, 55}},
                                   8);
  EXPECT_EQ(found.report.simplified->components_dropped, 2U);
  EXPECT_GT(found.report.simplified->triangles_dropped, 0U);
  EXPECT_EQ(check_topology(found.surface, {}).components.size(), 3U);
}

TEST(simplified_band, keeps_what_lies_round_something_that_stays) {
  // A speck of 58 with a pit of 10 in it: the shell round it is in the band, the pit is not.
  std::vector<std::pair<Index3, double>> changes;
  for (int z = 3; z <= 7; ++z)
    for (int y = 3; y <= 7; ++y)
      for (int x = 3; x <= 7; ++x) changes.push_back({{{x, y, z}}, 55});
  for (auto& [p, value] : changes)
    if (p == Index3{{5, 5, 5}}) value = 10;
  const Simplified kept = of_ball(changes, 8);
  EXPECT_EQ(kept.report.simplified->components_dropped, 0U);
  EXPECT_EQ(check_topology(kept.surface, {}).components.size(), 3U);
  for (auto& [p, value] : changes)
    if (p == Index3{{5, 5, 5}}) value = 45;
  const Simplified gone = of_ball(changes, 8);
  EXPECT_EQ(gone.report.simplified->components_dropped, 2U);
  EXPECT_EQ(check_topology(gone.surface, {}).components.size(), 1U);
}

TEST(simplified_band, drops_none_where_the_topology_is_kept_or_a_distance) {
  const std::vector<std::pair<Index3, double>> changes = {{{{4, 4, 4}}, 55}};
  const Dataset dataset = test::built_dataset(ball_with(changes));
  ExtractOptions options{.isovalues = {50}, .max_error = 8, .keep_topology = 0, .threads = {2}};
  options.simplify = Simplify::edges;
  EXPECT_EQ(check_topology(simplified(dataset, options).surface, {}).components.size(), 2U);
  options.keep_topology.reset();
  options.simplify_distance = 0.5;
  const Simplified found = simplified(dataset, options);
  EXPECT_LE(found.report.simplified->proven_distance, 0.5);
  EXPECT_LE(found.report.simplified->proven_error, 8);
}

/// Specks that extraction within half of the error leaves out, and rough fields.
TEST(simplified_band, is_within_a_distance_of_full_resolution_too) {
  RegularGrid grid;
  grid.dims = {{24, 24, 24}};
  const Volume specks = oracles::volume_of<std::uint8_t>(grid, [](const Index3& p) {
    const Vec3d r{{p[0] - 10.5, p[1] - 10.5, p[2] - 10.5}};
    if (dot(r, r) < 36) return 90.0;
    return p[0] % 7 == 6 && p[1] % 7 == 5 && p[2] % 7 == 6 ? 51.0 : 49.0;
  });
  struct Case {
    const Volume& volume;
    double isovalue, error, distance;
  };
  const Volume rough_one = rough_volume<float>({{20, 18, 16}}, 100, 5);
  for (const auto& [volume, isovalue, error, distance] : trials<std::vector<Case>>(
           {{specks, 50, 10, 0.5}, {rough_one, 5, 30, 0.4}, {rough_one, 5, 30, 1.5}},
           {{specks, 50, 10, 0.5}, {rough_one, 5, 30, 1.5}})) {
    SCOPED_TRACE(distance);
    const Dataset dataset = test::built_dataset(volume);
    ExtractOptions options{.isovalues = {isovalue}, .max_error = 0.0, .threads = {2}};
    Progress progress;
    Surface full;
    ASSERT_TRUE(dataset.extract(options, full, progress));
    options.max_error = error;
    options.simplify = Simplify::edges;
    options.simplify_distance = distance;
    const Simplified found = simplified(dataset, options);
    const auto measured = measure_distance(found.surface, full, {distance / 64, {2}}, progress);
    ASSERT_TRUE(measured);
    EXPECT_LE(measured->lower(), distance * 1.00001);
    ASSERT_TRUE(found.report.simplified);
    EXPECT_LE(found.report.simplified->proven_distance, distance);
    EXPECT_LT(found.surface.triangles.size(), full.triangles.size());
  }
}

/// Where the isovalue is that of samples, triangles at these are thousands of times shorter than
/// others.
TEST(simplified_band, is_as_small_at_an_isovalue_of_samples) {
  RegularGrid grid;
  grid.dims = {{48, 48, 48}};
  const Volume ball = oracles::volume_of<std::uint8_t>(grid, [](const Index3& p) {
    const Vec3d r{{p[0] - 23.2, p[1] - 24.1, p[2] - 23.7}};
    return std::round(200 - 5 * length(r));
  });
  const Dataset dataset = test::built_dataset(ball);
  for (const bool is_in_band : {false, true}) {
    const auto n_triangles = [&](double isovalue) {
      ExtractOptions options{.isovalues = {isovalue}, .max_error = 0.0, .threads = {2}};
      options.simplify = Simplify::edges;
      if (is_in_band)
        options.max_error = 4;
      else
        options.simplify_distance = 0.5;
      return simplified(dataset, options).surface.triangles.size();
    };
    EXPECT_LT(n_triangles(110), 2 * n_triangles(110.5)) << is_in_band;
  }
}

/// Single samples, rows and clusters of them that are the isovalue: closed pieces no wider than
/// rounding, which stay as they face.
TEST(simplified_band, turns_no_closed_piece_inside_out) {
  RegularGrid grid;
  grid.dims = trials<Index3>({{40, 40, 40}}, {{24, 24, 24}});
  grid.origin = {{100, 100, 100}};
  Random random(21);
  const Volume specks = oracles::volume_of<std::uint8_t>(grid, [&](const Index3&) {
    const std::uint64_t n = random.below(100);
    return n < 12 ? 40.0 : n < 14 ? 41.0 : 20.0 + static_cast<double>(n % 19);
  });
  const Dataset dataset = test::built_dataset(specks);
  for (const double distance : {0.3, 1.0}) {
    ExtractOptions options{.isovalues = {40}, .max_error = 0.0, .threads = {2}};
    options.simplify = Simplify::edges;
    options.simplify_distance = distance;
    EXPECT_GT(simplified(dataset, options).surface.triangles.size(), 0U);
  }
}

TEST(simplified_band, may_leave_nothing_at_all) {
  const Volume volume = rough_volume<float>({{9, 9, 9}}, 1, 12);
  const Dataset dataset = test::built_dataset(volume);
  ExtractOptions options{.isovalues = {7}, .max_error = 0.1, .threads = {2}};
  options.simplify = Simplify::edges;
  EXPECT_TRUE(simplified(dataset, options).surface.triangles.empty());
  RegularGrid grid;
  grid.dims = {{9, 9, 9}};
  const Volume speck = oracles::volume_of<float>(grid, [](const Index3& p) {
    return p == Index3{{4, 4, 4}} ? 1 : 0;
  });
  options = {.isovalues = {0.5}, .max_error = 0.6, .threads = {2}};
  options.simplify = Simplify::edges;
  const Simplified gone = simplified(test::built_dataset(speck), options);
  EXPECT_TRUE(gone.surface.triangles.empty());
  EXPECT_TRUE(gone.surface.positions.empty());
}

TEST(simplified_band, of_cubes_holds_too) {
  const Volume volume =
      rough_volume<std::int16_t>(trials<Index3>({{40, 37, 23}}, {{40, 25, 13}}), 1000, 13);
  const Dataset dataset = test::built_dataset(volume);
  for (const double error : {60.0, 300.0}) {
    ExtractOptions options{
        .isovalues = {12}, .max_error = error, .style = SurfaceStyle::cubes, .threads = {2}};
    options.simplify = Simplify::edges;
    EXPECT_GT(simplified(dataset, options).report.simplified->collapses, 100U);
  }
}

TEST(simplified_band, refuses_what_has_no_proof) {
  const Dataset dataset = test::built_dataset(rough_volume<float>({{9, 9, 9}}, 1, 14));
  const auto expect_refused = [&](ExtractOptions options, const char* why) {
    options.simplify = Simplify::edges;
    Progress progress;
    Surface surface;
    const auto report = dataset.extract(options, surface, progress);
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().message.find(why), std::string::npos) << report.error().message;
  };
  expect_refused({.isovalues = {0, 0.1}, .max_error = 0.1}, "expected one isovalue, got 2");
  expect_refused({.isovalues = {0}, .max_error = 0.0}, "expected a finite max_error > 0");
  expect_refused({.isovalues = {0}, .max_error = 0.1, .clip = Box3d{{{0, 0, 0}}, {{5, 5, 5}}}},
                 "expected no clip box");
  expect_refused({.isovalues = {0}, .max_error = 0.1, .min_component = 5}, "expected all pieces");
  expect_refused({.isovalues = {0}, .max_distance = 1.0}, "expected a finite max_error > 0");
  expect_refused({.isovalues = {0}, .max_error = 0.1, .border = Border::closed},
                 "expected an open border");
}

diamond::SideReport sides_of(const Volume& volume, const Surface& surface, double isovalue,
                             double error) {
  Progress progress;
  const diamond::VolumeSamples samples(volume);
  return diamond::check_sides(samples, surface, {.isovalue = isovalue, .error = error}, progress)
      .value();
}

Surface full_resolution(const Volume& volume, double isovalue) {
  Progress progress;
  Surface surface;
  EXPECT_TRUE(test::built_dataset(volume).extract({.isovalues = {isovalue}, .max_error = 0.0},
                                                  surface, progress));
  return surface;
}

TEST(side_check, passes_full_resolution_and_finds_each_sample_on_the_wrong_side) {
  const Volume volume = rough_volume<float>({{20, 17, 23}}, 1, 15);
  const Surface surface = full_resolution(volume, 0.05);
  EXPECT_EQ(sides_of(volume, surface, 0.05, 0).n_wrong, 0U);
  EXPECT_GT(sides_of(volume, surface, 0.05, 0).n_pairs, 15'000U);
  // Of another isovalue some samples are on the wrong side, unless they do not matter.
  EXPECT_GT(sides_of(volume, surface, 0.02, 0.02).n_wrong, 0U);
  EXPECT_EQ(sides_of(volume, surface, 0.02, 0.031).n_wrong, 0U);
}

TEST(side_check, finds_a_component_that_is_missing) {
  const Volume volume = ball_with({{{{4, 4, 4}}, 59}});
  const Surface with = full_resolution(volume, 50);
  const Surface without = full_resolution(ball_with({}), 50);
  EXPECT_EQ(sides_of(volume, with, 50, 8).n_wrong, 0U);
  const diamond::SideReport found = sides_of(volume, without, 50, 8);
  EXPECT_EQ(found.n_wrong, 6U);  // before and behind it along each axis
  EXPECT_EQ(sides_of(volume, without, 50, 9.5).n_wrong, 0U);
}

}  // namespace
}  // namespace lode
