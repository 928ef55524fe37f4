// Simplification within a distance that begins with cubes: what is promised of the tetrahedra.

#include <gtest/gtest.h>

#include <cmath>

#include "lode/api/dataset.h"
#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"

namespace lode::begun_with_cubes {
namespace {

RegularGrid plain_grid() {
  RegularGrid grid;
  grid.dims = {{26, 24, 22}};
  return grid;
}

/// Waves, and noise on top.
Volume waves(const RegularGrid& grid, double noise = 2) {
  oracles::Random random(3);
  return oracles::volume_of<float>(grid, [&](const Index3& p) {
    return 100 + 40 * std::sin(0.4 * p[0]) * std::cos(0.35 * p[1] + 0.2 * p[2]) + 2 * p[2] +
           random.uniform(-noise, noise);
  });
}

ExtractOptions within(double distance, int threads = 2) {
  ExtractOptions options{.isovalues = {124.5}, .max_error = 0.0, .threads = {threads}};
  options.simplify = Simplify::edges;
  options.simplify_distance = distance;
  return options;
}

Dataset dataset_of(const Volume& volume) {
  Progress progress;
  return Dataset::build(*make_memory_source(volume), {.threads = {2}}, progress).value();
}

/// Verified against the tetrahedra. Returns how far what collapses began with was from these.
double start_of(const Dataset& dataset, const ExtractOptions& options, Surface& surface) {
  Progress progress;
  const auto report = dataset.extract(options, surface, progress);
  if (!report || !report->simplified) {
    ADD_FAILURE() << (report ? "not simplified" : report.error().message);
    return 0;
  }
  EXPECT_EQ(report->simplified->max_distance, *options.simplify_distance);
  EXPECT_LE(report->simplified->proven_distance, *options.simplify_distance);
  EXPECT_LE(report->simplified->start_distance, report->simplified->proven_distance);
  const auto verified = dataset.verify_surface(surface, options, progress);
  EXPECT_TRUE(verified) << verified.error().message;
  for (const VerifyReport::Check& check : verified->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  return report->simplified->start_distance;
}

double start_of(const Volume& volume, const ExtractOptions& options) {
  Surface surface;
  return start_of(dataset_of(volume), options, surface);
}

TEST(simplified_cubes, keep_what_is_promised_of_the_tetrahedra_in_any_grid) {
  RegularGrid longer = plain_grid();
  longer.spacing = {{0.5, 1.25, 0.8}};
  RegularGrid turned = longer;
  turned.direction = Mat3{{{{{0, 0, -1}}, {{1, 0, 0}}, {{0, 1, 0}}}}};
  RegularGrid oblique = plain_grid();
  oblique.direction = Mat3{{{{{0.8, -0.6, 0}}, {{0.6, 0.8, 0.1}}, {{0, 0, 1}}}}};
  RegularGrid far = plain_grid();  // where margins and rounding are large
  far.origin = {{2049, -1800, 1500}};
  for (const RegularGrid& grid : {plain_grid(), longer, turned, oblique, far})
    for (const double distance : {1.3, 2.8}) {
      SCOPED_TRACE(distance);
      const double start = start_of(waves(grid, 0.5), within(distance));
      EXPECT_GT(start, 0.2 * distance - 1e-9);
      EXPECT_LT(start, 0.21 * distance);
    }
}

TEST(simplified_cubes, leave_fewer_triangles_and_are_the_same_for_any_threads) {
  const Dataset dataset = dataset_of(waves(plain_grid()));
  Surface one;
  Surface three;
  EXPECT_GT(start_of(dataset, within(2.5, 1), one), 0);
  EXPECT_GT(start_of(dataset, within(2.5, 3), three), 0);
  EXPECT_EQ(one.triangles, three.triangles);
  EXPECT_EQ(one.positions, three.positions);
}

TEST(simplified_cubes, are_begun_with_beside_holes_from_two_steps_on) {
  Volume volume = waves(plain_grid());
  oracles::Random random(11);
  for (float& sample : oracles::typed_samples<float>(volume))
    if (random.below(200) == 0) sample = std::nanf("");
  EXPECT_GT(start_of(volume, within(2.2)), 0);
  EXPECT_EQ(start_of(volume, within(1.2)), 0);
}

TEST(simplified_cubes, are_not_begun_with_where_few_are_near) {
  EXPECT_GT(start_of(waves(plain_grid(), 0.5), within(1)), 0);
  EXPECT_EQ(start_of(waves(plain_grid(), 0.5), within(0.99)), 0);
  EXPECT_EQ(start_of(waves(plain_grid(), 30), within(1)), 0);
  EXPECT_GT(start_of(waves(plain_grid(), 30), within(2)), 0);
}

/// Cubes of two isovalues could meet.
TEST(simplified_cubes, are_not_begun_with_for_several_isovalues) {
  ExtractOptions two = within(2.5);
  two.isovalues = {124.5, 125};
  EXPECT_EQ(start_of(waves(plain_grid()), two), 0);
}

TEST(simplified_cubes, are_not_begun_with_where_tetrahedra_are_to_be_seen) {
  const Dataset dataset = dataset_of(waves(plain_grid(), 0.5));
  Progress progress;
  const auto start = [&](const ExtractOptions& options) {
    Surface surface;
    return dataset.extract(options, surface, progress).value().simplified->start_distance;
  };
  ExtractOptions clipped = within(2.5);
  clipped.clip = Box3d{{{2, 2, 2}}, {{20, 20, 20}}};
  EXPECT_EQ(start(clipped), 0);
  ExtractOptions large = within(2.5);
  large.min_component = 3;
  EXPECT_EQ(start(large), 0);
  ExtractOptions slivers = within(2.5);
  slivers.simplify = Simplify::slivers;
  EXPECT_EQ(start(slivers), 0);
  ExtractOptions cubes = within(2.5);
  cubes.style = SurfaceStyle::cubes;
  EXPECT_EQ(start(cubes), 0);
}

}  // namespace
}  // namespace lode::begun_with_cubes
