// Surfaces that are simplified piece by piece on their way from a model's file to a surface file.
#include <filesystem>

#include "lode/api/dataset_impl.h"
#include "lode/api/files.h"
#include "tests/models/stored_fixtures.h"
#include "tests/models/volume_files.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

using store::TestPath;
using test::stored;

RegularGrid grid_of(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  return grid;
}

/// Of several chunks.
RegularGrid long_grid() {
  return grid_of(oracles::trials<Index3>({{560, 40, 32}}, {{1100, 16, 12}}));
}

/// Waves through several chunks, with noise that makes small pieces.
Volume noisy_waves(const RegularGrid& grid, double noise = 1) {
  return oracles::volume_of<std::uint8_t>(grid, [&](const Index3& p) {
    const auto hash = static_cast<std::uint32_t>(p[0]) * 73856093U ^
                      static_cast<std::uint32_t>(p[1]) * 19349663U ^
                      static_cast<std::uint32_t>(p[2]) * 83492791U;
    return 120 + 50 * std::sin(0.11 * p[0]) * std::cos(0.09 * p[1] + 0.05 * p[2]) +
           noise * static_cast<double>(hash * 2654435761U >> 30);
  });
}

struct Simplified {
  ExtractReport report;
  Surface surface;
};

ExtractOptions within_distance() {
  ExtractOptions options{.isovalues = {124.5}, .max_error = 0};
  options.simplify = Simplify::edges;
  options.simplify_distance = 0.6;
  return options;
}

ExtractOptions within_error(double max_error) {
  ExtractOptions options{.isovalues = {124.5}, .max_error = max_error};
  options.simplify = Simplify::edges;
  return options;
}

/// From a file that the memory limit does not let in.
void simplify_by_pieces(const std::string& lode, const char* extension, ExtractOptions options,
                        Threads threads, Simplified& result) {
  const std::string out = lode + extension;
  const auto dataset = Dataset::open(lode, threads);
  ASSERT_TRUE(dataset);
  options.memory_limit = dataset->impl().chunk_bytes();
  options.threads = threads;
  ASSERT_LT(options.memory_limit, dataset->impl().model_bytes());
  Progress progress;
  ASSERT_TRUE(dataset->comes_in_pieces(options, progress).value());
  const auto report = extract_to_file(
      *dataset, options, out, [](const ExtractReport&) { return SurfaceWriteOptions{}; }, progress);
  ASSERT_TRUE(report) << report.error().message;
  result.report = *report;
  auto surface = read_surface(out);
  ASSERT_TRUE(surface) << surface.error().message;
  result.surface = std::move(*surface);
  std::filesystem::remove(out);
}

/// All that is promised of a simplified surface, by verification's own means.
void expect_verified(const std::string& lode, const ExtractOptions& options,
                     const Surface& surface) {
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  Progress progress;
  const auto verified = dataset->verify_surface(surface, options, progress);
  ASSERT_TRUE(verified) << verified.error().message;
  for (const VerifyReport::Check& check : verified->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

void expect_simplified(const Volume& volume, const char* extension,
                       const ExtractOptions& options = within_distance()) {
  const TestPath path("simplified.lode");
  const std::string lode = stored(path, volume);
  Simplified result;
  simplify_by_pieces(lode, extension, options, {2}, result);
  if (testing::Test::HasFatalFailure()) return;
  ASSERT_TRUE(result.report.simplified);
  const SimplifyReport& simplified = *result.report.simplified;
  EXPECT_EQ(simplified.triangles, result.surface.triangles.size());
  EXPECT_EQ(result.report.triangles, result.surface.triangles.size());
  EXPECT_EQ(result.report.vertices, result.surface.positions.size());

  // Some pieces are cut.
  const bool begins_near = options.simplify_distance.value_or(0) >= 2;
  EXPECT_EQ(simplified.start_distance > 0, begins_near);
  EXPECT_GT(simplified.triangles_before,
            begins_near || options.style == SurfaceStyle::cubes ? 20'000U : 40'000U);
  EXPECT_LT(simplified.triangles, simplified.triangles_before / 2);
  if (options.simplify_distance) EXPECT_LE(simplified.proven_distance, *options.simplify_distance);
  EXPECT_EQ(result.report.max_error, *options.max_error);
  EXPECT_EQ(simplified.max_error, *options.max_error);
  EXPECT_LE(simplified.proven_error, *options.max_error);
  if (options.keep_topology) EXPECT_GT(result.report.topology->weak_regions, 10U);
  for (const Vec3f& n : result.surface.normals) ASSERT_NEAR(length(n), 1, 1e-3);
  expect_verified(lode, options, result.surface);
}

TEST(simplified_pieces, fit_together_and_keep_what_is_promised_of_the_whole) {
  expect_simplified(noisy_waves(long_grid()), ".ply");
}

RegularGrid turned_grid() {
  RegularGrid grid = grid_of({{1150, 6, 270}});
  grid.spacing = {{1, 1.25, 0.8}};
  grid.origin = {{-1000.25, 5, 17}};
  grid.direction = Mat3{{{{{0, 0, -1}}, {{1, 0, 0}}, {{0, 1, 0}}}}};
  return grid;
}

TEST(simplified_pieces, may_be_mirrored_turned_and_longer_along_an_axis) {
  ASSERT_TRUE(turned_grid().has_world_axes());
  expect_simplified(noisy_waves(turned_grid(), 0), ".vtp");
}

Volume waves_with_holes() {
  Volume volume = noisy_waves(long_grid());
  volume.info.nodata = 7;
  oracles::Random random(11);
  for (std::uint8_t& sample : oracles::typed_samples<std::uint8_t>(volume))
    if (random.below(300) == 0) sample = 7;
  return volume;
}

TEST(simplified_pieces, may_end_at_holes) { expect_simplified(waves_with_holes(), ".ply"); }

TEST(simplified_pieces, stay_within_an_error) {
  expect_simplified(noisy_waves(long_grid()), ".ply", within_error(4));
  expect_simplified(noisy_waves(long_grid()), ".vtp", within_error(30));
  if (oracles::trials(true, false))
    expect_simplified(noisy_waves(turned_grid(), 0), ".vtp", within_error(6));
  expect_simplified(waves_with_holes(), ".ply", within_error(8));
}

TEST(simplified_pieces, stay_within_an_error_and_a_distance) {
  ExtractOptions options = within_error(10);
  options.simplify_distance = 0.6;
  expect_simplified(noisy_waves(long_grid()), ".ply", options);
}

TEST(simplified_pieces, may_begin_with_cubes) {
  ExtractOptions far = within_distance();
  far.simplify_distance = 2.2;
  expect_simplified(noisy_waves(long_grid()), ".ply", far);
  expect_simplified(waves_with_holes(), ".vtp", far);
}

TEST(simplified_pieces, may_be_of_cubes) {
  ExtractOptions near = within_distance();
  near.style = SurfaceStyle::cubes;
  expect_simplified(noisy_waves(long_grid()), ".ply", near);
  ExtractOptions in_band = within_error(8);
  in_band.style = SurfaceStyle::cubes;
  expect_simplified(noisy_waves(long_grid()), ".ply", in_band);
  expect_simplified(waves_with_holes(), ".vtp", in_band);
}

TEST(simplified_pieces, may_be_without_what_does_not_persist) {
  ExtractOptions near = within_distance();
  near.keep_topology = 1.2;
  expect_simplified(noisy_waves(long_grid()), ".ply", near);
  ExtractOptions far = near;
  far.simplify_distance = 2.2;
  expect_simplified(noisy_waves(long_grid()), ".ply", far);
  ExtractOptions in_band = within_error(8);
  in_band.keep_topology = 20;
  expect_simplified(noisy_waves(long_grid(), 3), ".ply", in_band);
  if (!oracles::trials(true, false)) return;
  in_band.keep_topology = 1.2;
  expect_simplified(noisy_waves(long_grid()), ".ply", in_band);
  near.style = SurfaceStyle::cubes;
  expect_simplified(noisy_waves(long_grid()), ".vtp", near);
}

TEST(simplified_pieces, drop_specks_in_the_band_that_lie_in_one) {
  Volume volume = noisy_waves(grid_of({{560, 40, 32}}), 0);
  auto samples = oracles::typed_samples<std::uint8_t>(volume);
  const auto put = [&](const Index3& p, std::uint8_t value) {
    samples[static_cast<std::size_t>(p[0] + 560 * (p[1] + 40 * p[2]))] = value;
  };
  for (std::int32_t z = 1; z < 31; ++z)
    for (std::int32_t y = 1; y < 39; ++y)
      for (std::int32_t x = 60; x < 75; ++x) put({{x, y, z}}, 122);
  put({{67, 10, 10}}, 127);
  put({{70, 20, 10}}, 126);
  put({{66, 30, 20}}, 180);
  const TestPath path("specks.lode");
  const std::string lode = stored(path, volume);
  Simplified result;
  simplify_by_pieces(lode, ".ply", within_error(4), {2}, result);
  ASSERT_TRUE(result.report.simplified);
  EXPECT_EQ(result.report.simplified->components_dropped, 2U);
  expect_verified(lode, within_error(4), result.surface);
}

TEST(simplified_pieces, within_an_error_come_to_memory_too) {
  const TestPath path("collected.lode");
  const std::string lode = stored(path, noisy_waves(long_grid()));
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  ExtractOptions options = within_error(10);
  options.memory_limit = dataset->impl().chunk_bytes();
  Surface surface;
  Progress progress;
  const auto report = dataset->extract(options, surface, progress);
  ASSERT_TRUE(report) << report.error().message;
  Simplified written;
  simplify_by_pieces(lode, ".vtp", options, {1}, written);
  EXPECT_EQ(surface.triangles, written.surface.triangles);
  expect_verified(lode, options, surface);
}

TEST(simplified_pieces, are_the_same_for_any_number_of_threads) {
  const TestPath path("threads.lode");
  const std::string lode = stored(
      path, noisy_waves(grid_of(oracles::trials<Index3>({{800, 24, 20}}, {{1100, 16, 12}}))));
  Simplified one;
  Simplified three;
  for (const ExtractOptions& options : {within_distance(), within_error(7)}) {
    simplify_by_pieces(lode, ".vtp", options, {1}, one);
    simplify_by_pieces(lode, ".vtp", options, {3}, three);
    EXPECT_TRUE(one.surface.positions == three.surface.positions);
    EXPECT_TRUE(one.surface.triangles == three.surface.triangles);
    EXPECT_FALSE(one.surface.is_empty());
  }
}

TEST(simplified_pieces, come_where_the_model_fits_and_simplifying_all_of_it_does_not) {
  const TestPath path("fits.lode");
  const std::string lode = stored(path, noisy_waves(grid_of({{800, 24, 20}})));
  const auto dataset = Dataset::open(lode, {1});
  ASSERT_TRUE(dataset);
  Progress progress;
  ExtractOptions options = within_distance();
  options.memory_limit = dataset->impl().model_bytes() + 1'000'000;
  EXPECT_TRUE(dataset->comes_in_pieces(options, progress).value());
  EXPECT_TRUE(dataset->comes_in_pieces(options, progress).value()) << "nor when asked again";
  EXPECT_TRUE(dataset->impl().is_in_file()) << "the model was let go of";
  options.memory_limit = std::uint64_t{1} << 32;
  EXPECT_FALSE(dataset->comes_in_pieces(options, progress).value());
}

TEST(simplified_pieces, are_of_one_isovalue_in_frames_like_the_worlds) {
  const TestPath path("refused.lode");
  RegularGrid grid = grid_of({{800, 24, 20}});
  const auto ask = [&](const ExtractOptions& options) {
    const std::string lode = stored(path, noisy_waves(grid));
    const auto dataset = Dataset::open(lode, {1});
    ExtractOptions limited = options;
    limited.memory_limit = dataset->impl().chunk_bytes();
    Progress progress;
    return dataset->comes_in_pieces(limited, progress);
  };
  const auto comes_in_pieces = [&](const ExtractOptions& options) { return ask(options).value(); };
  const ExtractOptions options = within_distance();
  EXPECT_TRUE(comes_in_pieces(options));
  EXPECT_TRUE(comes_in_pieces(within_error(3)));
  ExtractOptions two = options;
  two.isovalues.push_back(110);
  EXPECT_FALSE(comes_in_pieces(two));
  grid.direction = Mat3{{{{{0.8, -0.6, 0}}, {{0.6, 0.8, 0}}, {{0, 0, 1}}}}};
  EXPECT_FALSE(comes_in_pieces(options));
  const auto refused = ask(within_error(3));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("whose axes are not the world's: expected a memory limit"),
            std::string::npos);
}

}  // namespace
}  // namespace lode
