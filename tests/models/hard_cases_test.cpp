// Fields that break extraction in practice: each surface is checked by everything `verify` has.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "lode/api/dataset.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/persist.h"
#include "tests/models/finest_level_set.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using oracles::volume_of;

RegularGrid grid_with(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  return grid;
}

Result<Dataset> built(const Volume& volume) {
  Progress progress;
  return Dataset::build(*make_memory_source(volume), {.threads = {2}}, progress);
}

void expect_holds(const Result<VerifyReport>& report) {
  ASSERT_TRUE(report) << report.error().message;
  for (const VerifyReport::Check& check : report->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

/// Builds, compares with the original, and extracts and checks at each tolerance.
std::uint64_t expect_true_everywhere(const Volume& volume, double isovalue,
                                     const std::vector<double>& tolerances) {
  Progress progress;
  const auto source = make_memory_source(volume);
  const auto dataset = Dataset::build(*source, {.threads = {2}}, progress);
  EXPECT_TRUE(dataset) << (dataset ? "" : dataset.error().message);
  expect_holds(dataset->verify_against(*source, {2}, progress));
  std::uint64_t n_triangles = 0;
  for (const double tolerance : tolerances) {
    Surface surface;
    const ExtractOptions options{.isovalues = {isovalue}, .max_error = tolerance, .threads = {2}};
    const auto report = dataset->extract(options, surface, progress);
    EXPECT_TRUE(report);
    expect_holds(dataset->verify_surface(surface, options, progress));
    n_triangles += surface.triangles.size();
  }
  return n_triangles;
}

double wave(const Index3& p) {
  return std::sin(0.4 * p[0]) + std::cos(0.3 * p[1] + 0.2 * p[2]) * std::sin(0.25 * p[2]);
}

TEST(hard_cases, a_constant_volume_has_no_surface) {
  const auto volume =
      volume_of<std::uint8_t>(grid_with({{9, 8, 7}}), [](const Index3&) { return 7; });
  for (const double isovalue : {6.0, 7.0, 8.0})
    EXPECT_EQ(expect_true_everywhere(volume, isovalue, {0, 1}), 0U);
}

TEST(hard_cases, a_checkerboard_of_extremes) {
  const auto volume = volume_of<std::uint8_t>(grid_with({{12, 11, 10}}), [](const Index3& p) {
    return (p[0] + p[1] + p[2]) % 2 == 0 ? 0 : 255;
  });
  EXPECT_GT(expect_true_everywhere(volume, 127.5, {0, 100, 254}), 1000U);
}

TEST(hard_cases, a_small_signal_on_a_huge_offset) {
  const auto field = [](const Index3& p) { return 1e9 + wave(p); };
  EXPECT_GT(expect_true_everywhere(volume_of<double>(grid_with({{30, 20, 19}}), field), 1e9 + 0.3,
                                   {0, 0.05, 0.5}),
            100U);
  // float32 keeps steps of 64 at 1e9: the samples are what is left, and true to themselves.
  const auto coarse = [](const Index3& p) { return 1e9 + 400 * wave(p); };
  EXPECT_GT(expect_true_everywhere(volume_of<float>(grid_with({{30, 20, 19}}), coarse), 1e9 + 130,
                                   {0, 100}),
            100U);
}

TEST(hard_cases, origins_far_from_zero) {
  RegularGrid grid = grid_with({{20, 21, 22}});
  grid.origin = {{500000.5, 4649776.25, -1200}};
  grid.spacing = {{0.001, 0.002, 0.001}};
  EXPECT_GT(expect_true_everywhere(volume_of<float>(grid, wave), 0.3, {0, 0.2}), 100U);
}

TEST(hard_cases, mirrored_and_oblique_directions) {
  RegularGrid grid = grid_with({{20, 18, 17}});
  grid.spacing = {{1, 0.25, 3}};
  grid.direction = {{Vec3d{{-1, 0, 0}}, Vec3d{{0, -1, 0}}, Vec3d{{0, 0, -1}}}};
  EXPECT_GT(expect_true_everywhere(volume_of<float>(grid, wave), 0.3, {0, 0.2}), 100U);
  const double c = std::cos(0.7);
  const double s = std::sin(0.7);
  grid.direction = {{Vec3d{{c, s, 0}}, Vec3d{{s, -c, 0}}, Vec3d{{0, 0, 1}}}};
  EXPECT_GT(expect_true_everywhere(volume_of<float>(grid, wave), 0.3, {0, 0.2}), 100U);
}

/// As of the same samples with steps of one, but for rounding: no step costs another axis accuracy.
TEST(hard_cases, steps_of_very_different_lengths) {
  oracles::Random random(7);
  const Index3 dims{{17, 16, 15}};
  std::vector<double> noise(static_cast<std::size_t>(17 * 16 * 15));
  for (double& value : noise) value = static_cast<double>(random.below(256));
  const auto field = [&](const Index3& p) {
    return noise[static_cast<std::size_t>((p[2] * 16 + p[1]) * 17 + p[0])];
  };
  const auto extracted = [&](const RegularGrid& grid) {
    const auto dataset = built(volume_of<std::uint8_t>(grid, field));
    Progress progress;
    Surface surface;
    const auto report =
        dataset->extract({.isovalues = {127.5}, .max_error = 0, .threads = {2}}, surface, progress);
    EXPECT_LT(report->coordinate_slack, 0.2);
    return surface;
  };
  const Surface unit = extracted(grid_with(dims));
  for (const Vec3d& spacing : {Vec3d{{0.01, 0.01, 50}}, {{1e-4, 1, 1e4}}, {{1e5, 1e-3, 1e-3}}}) {
    RegularGrid grid = grid_with(dims);
    grid.spacing = spacing;
    const Surface surface = extracted(grid);
    ASSERT_EQ(surface.triangles, unit.triangles);
    for (std::uint32_t v = 0; v < surface.positions.size(); ++v)
      for (std::size_t i = 0; i < 3; ++i)
        ASSERT_NEAR(surface.positions[v][i] / spacing[i], unit.positions[v][i], 1e-4);
    const auto volume = volume_of<std::uint8_t>(grid, field);
    EXPECT_GT(expect_true_everywhere(volume, 127.5, {0, 60}), 1000U);
  }
}

TEST(hard_cases, thin_slabs) {
  EXPECT_GT(
      expect_true_everywhere(volume_of<std::int16_t>(grid_with({{90, 70, 5}}),
                                                     [](const Index3& p) { return 100 * wave(p); }),
                             30.5, {0, 20}),
      100U);
}

TEST(hard_cases, nan_blocks_and_five_percent_of_scattered_nan) {
  const auto nan = std::nan("");
  for (const Index3& dims : {Index3{{19, 18, 17}}, Index3{{2, 60, 2}}, Index3{{1, 40, 40}},
                             Index3{{3, 3, 3}}, Index3{{34, 9, 5}}}) {
    const auto block = volume_of<float>(grid_with(dims), [&](const Index3& p) {
      const bool is_hole = p[0] <= dims[0] / 2 && p[1] > dims[1] / 3 && p[1] < 2 * dims[1] / 3;
      return is_hole ? nan : wave(p);
    });
    expect_true_everywhere(block, 0.3, {0, 0.4});
    oracles::Random random(17);
    const auto scattered = volume_of<float>(
        grid_with(dims), [&](const Index3& p) { return random.uniform() < 0.05 ? nan : wave(p); });
    expect_true_everywhere(scattered, 0.3, {0, 0.4});
  }
}

TEST(hard_cases, a_slab_of_a_whole_scan) {
  // 512 x 512 x 34 in a cube of 512: nothing outside the slab may cost time or memory.
  const auto volume = volume_of<std::int16_t>(grid_with({{512, 512, 34}}), [](const Index3& p) {
    return 1000 - 40 * std::hypot(p[0] - 100.0, p[1] - 400.0, 3.0 * (p[2] - 33.0));
  });
  Progress progress;
  const auto dataset = built(volume);
  ASSERT_TRUE(dataset);
  for (const double tolerance : {0.0, 100.0}) {
    Surface surface;
    const ExtractOptions options{.isovalues = {300}, .max_error = tolerance, .threads = {2}};
    const auto report = dataset->extract(options, surface, progress);
    ASSERT_TRUE(report);
    EXPECT_GT(surface.triangles.size(), 100U);
    EXPECT_LT(report->nodes_visited, 100000U);
    EXPECT_TRUE(check_topology(surface, {}).is_clean_manifold());
    if (tolerance > 0) expect_holds(dataset->verify_surface(surface, options, progress));
  }
}

TEST(hard_cases, simplices_that_reach_across_two_border_planes) {
  // They are refined along the edge where both planes meet.
  const auto volume = volume_of<float>(
      grid_with({{65, 40, 36}}), [](const Index3& p) { return static_cast<double>(p[1] + p[2]); });
  Progress progress;
  const auto dataset = built(volume);
  ASSERT_TRUE(dataset);
  for (int i = 0; i < 30; ++i) {
    Surface surface;
    const ExtractOptions options{
        .isovalues = {66 + 0.13 * i}, .max_error = 10.0, .normals = Normals::off, .threads = {2}};
    ASSERT_TRUE(dataset->extract(options, surface, progress));
    expect_holds(dataset->verify_surface(surface, options, progress));
  }
}

TEST(hard_cases, clip_planes_through_vertices) {
  // Samples -1 and 1: vertices lie in the middle of edges, and so do the clip planes.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    oracles::Random random(seed);
    const auto volume = volume_of<float>(grid_with({{14, 12, 13}}), [&](const Index3&) {
      return random.uniform(0, 1) < 0.5 ? -1.0 : 1.0;
    });
    Progress progress;
    const auto dataset = built(volume);
    ASSERT_TRUE(dataset);
    for (const double max_error : {0.0, 1.0}) {
      Surface surface;
      const ExtractOptions options{.isovalues = {0},
                                   .max_error = max_error,
                                   .clip = Box3d{{{2.5, 1.5, 3.5}}, {{9.5, 8.5, 9.5}}},
                                   .threads = {2}};
      ASSERT_TRUE(dataset->extract(options, surface, progress));
      EXPECT_FALSE(surface.is_empty());
      expect_holds(dataset->verify_surface(surface, options, progress));
    }
  }
}

TEST(hard_cases, clip_planes_beside_vertices) {
  // Few different values, many equal to the isovalue: vertices at halves, thirds and whole numbers,
  // and the clip planes there too, give or take the rounding of either.
  for (std::uint64_t seed = 0; seed < oracles::trials(60U, 15U); ++seed) {
    oracles::Random random(seed);
    const auto volume = volume_of<std::uint8_t>(grid_with({{15, 17, 14}}), [&](const Index3& p) {
      return p[0] + p[2] + static_cast<double>(random.below(4));
    });
    const auto dataset = built(volume);
    ASSERT_TRUE(dataset);
    for (int i = 0; i < 4; ++i) {
      Box3d box;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = static_cast<double>(random.below(30)) / 6;
        box.upper[axis] = box.lower[axis] + 3 + static_cast<double>(random.below(30)) / 6;
      }
      Progress progress;
      Surface surface;
      const ExtractOptions options{.isovalues = {i % 2 == 0 ? 12.0 : 12.5},
                                   .max_error = 0.5 * i,
                                   .clip = box,
                                   .threads = {2}};
      ASSERT_TRUE(dataset->extract(options, surface, progress));
      expect_holds(dataset->verify_surface(surface, options, progress));
    }
  }
}

TEST(hard_cases, every_configuration_of_a_cell) {
  // All 256 sign patterns, the ambiguous ones of marching cubes among them.
  for (unsigned signs = 0; signs < 256; ++signs) {
    const auto volume = volume_of<float>(grid_with({{2, 2, 2}}), [&](const Index3& p) {
      return (signs >> (p[0] + 2 * p[1] + 4 * p[2])) & 1U;
    });
    Progress progress;
    const auto dataset = built(volume);
    ASSERT_TRUE(dataset);
    Surface surface;
    const ExtractOptions options{.isovalues = {0.5}, .max_error = 0.0, .threads = {1}};
    ASSERT_TRUE(dataset->extract(options, surface, progress));
    expect_holds(dataset->verify_surface(surface, options, progress));
    EXPECT_EQ(check_topology(surface, {}).euler_number,
              check_topology(test::finest_level_set(volume, 0.5), {}).euler_number)
        << "signs " << signs;
  }
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(hard_cases, reading_slab_by_slab_gives_the_same_file) {
  const auto path = (std::filesystem::temp_directory_path() /
                     ("lode_slabs_" + std::to_string(::getpid()) + ".lode"))
                        .string();
  const Volume volume = oracles::sample(oracles::Field::gaussians40, 128);
  Progress progress;
  std::string expected;
  for (const std::int32_t slices : {128, 16, 5}) {
    const auto source = make_memory_source(volume);
    const auto model =
        diamond::build<3>(*source, {.threads = {2}, .slices_per_read = slices}, progress);
    ASSERT_TRUE(model);
    ASSERT_TRUE(diamond::save<3>(*model, path, {2}, progress));
    const std::string bytes = bytes_of(path);
    if (expected.empty()) expected = bytes;
    EXPECT_TRUE(bytes == expected) << slices << " slices at a time";
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace lode
