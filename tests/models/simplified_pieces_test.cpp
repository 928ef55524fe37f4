// Surfaces that are simplified piece by piece on their way from a model's file to a surface file.
#include <filesystem>

#include "lode/api/dataset_impl.h"
#include "lode/api/files.h"
#include "tests/models/stored_fixtures.h"
#include "tests/models/volume_files.h"

namespace lode {
namespace {

using store::TestPath;
using test::stored;

RegularGrid grid_of(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  return grid;
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

/// From a file that the memory limit does not let in.
void simplify_by_pieces(const std::string& lode, const char* extension, Threads threads,
                        Simplified& result) {
  const std::string out = lode + extension;
  const auto dataset = Dataset::open(lode, threads);
  ASSERT_TRUE(dataset);
  ExtractOptions options{.isovalues = {124.5}, .max_error = 0};
  options.simplify = Simplify::edges;
  options.simplify_distance = 0.6;
  options.memory_limit = dataset->impl().chunk_bytes();
  options.threads = threads;
  ASSERT_LT(options.memory_limit, dataset->impl().model_bytes());
  ASSERT_TRUE(dataset->comes_in_pieces(options).value());
  Progress progress;
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
void expect_verified(const std::string& lode, const Surface& surface) {
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  ExtractOptions options{.isovalues = {124.5}, .max_error = 0};
  options.simplify = Simplify::edges;
  options.simplify_distance = 0.6;
  Progress progress;
  const auto verified = dataset->verify_surface(surface, options, progress);
  ASSERT_TRUE(verified) << verified.error().message;
  for (const VerifyReport::Check& check : verified->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

void expect_simplified(const Volume& volume, const char* extension) {
  const TestPath path("simplified.lode");
  const std::string lode = stored(path, volume);
  Simplified result;
  simplify_by_pieces(lode, extension, {2}, result);
  if (testing::Test::HasFatalFailure()) return;
  ASSERT_TRUE(result.report.simplified);
  const SimplifyReport& simplified = *result.report.simplified;
  EXPECT_EQ(simplified.triangles, result.surface.triangles.size());
  EXPECT_EQ(result.report.triangles, result.surface.triangles.size());
  EXPECT_EQ(result.report.vertices, result.surface.positions.size());
  EXPECT_GT(simplified.triangles_before, 40'000U);  // some pieces are cut
  EXPECT_LT(simplified.triangles, simplified.triangles_before / 2);
  EXPECT_LE(simplified.proven_distance, 0.6);
  if (result.surface.normals.empty()) return expect_verified(lode, result.surface);
  for (const Vec3f& n : result.surface.normals) ASSERT_NEAR(length(n), 1, 1e-3);
  expect_verified(lode, result.surface);
}

TEST(simplified_pieces, fit_together_and_keep_what_is_promised_of_the_whole) {
  expect_simplified(noisy_waves(grid_of({{560, 40, 32}})), ".ply");
}

TEST(simplified_pieces, may_be_mirrored_turned_and_longer_along_an_axis) {
  RegularGrid grid = grid_of({{1150, 6, 270}});
  grid.spacing = {{1, 1.25, 0.8}};
  grid.origin = {{-1000.25, 5, 17}};
  grid.direction = Mat3{{{{{0, 0, -1}}, {{1, 0, 0}}, {{0, 1, 0}}}}};
  ASSERT_TRUE(grid.has_world_axes());
  expect_simplified(noisy_waves(grid, 0), ".vtp");
}

TEST(simplified_pieces, may_end_at_holes) {
  Volume volume = noisy_waves(grid_of({{560, 40, 32}}));
  volume.info.nodata = 7;
  oracles::Random random(11);
  for (std::uint8_t& sample : oracles::typed_samples<std::uint8_t>(volume))
    if (random.below(300) == 0) sample = 7;
  expect_simplified(volume, ".ply");
}

TEST(simplified_pieces, are_the_same_for_any_number_of_threads) {
  const TestPath path("threads.lode");
  const std::string lode = stored(path, noisy_waves(grid_of({{800, 24, 20}})));
  Simplified one;
  Simplified three;
  simplify_by_pieces(lode, ".vtp", {1}, one);
  simplify_by_pieces(lode, ".vtp", {3}, three);
  EXPECT_TRUE(one.surface.positions == three.surface.positions);
  EXPECT_TRUE(one.surface.triangles == three.surface.triangles);
  EXPECT_FALSE(one.surface.is_empty());
}

TEST(simplified_pieces, are_of_full_resolution_and_one_isovalue_in_frames_like_the_worlds) {
  const TestPath path("refused.lode");
  RegularGrid grid = grid_of({{800, 24, 20}});
  const auto ask = [&](const ExtractOptions& options) {
    const std::string lode = stored(path, noisy_waves(grid));
    const auto dataset = Dataset::open(lode, {1});
    ExtractOptions limited = options;
    limited.memory_limit = dataset->impl().chunk_bytes();
    return dataset->comes_in_pieces(limited);
  };
  const auto comes_in_pieces = [&](const ExtractOptions& options) { return ask(options).value(); };
  ExtractOptions options{.isovalues = {124.5}, .max_error = 0};
  options.simplify = Simplify::edges;
  options.simplify_distance = 0.6;
  EXPECT_TRUE(comes_in_pieces(options));
  ExtractOptions coarse = options;
  coarse.max_error = 3;
  const auto refused = ask(coarse);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("simplifying within a max_error: expected a memory limit"),
            std::string::npos);
  ExtractOptions two = options;
  two.isovalues.push_back(110);
  EXPECT_FALSE(comes_in_pieces(two));
  grid.direction = Mat3{{{{{0.8, -0.6, 0}}, {{0.6, 0.8, 0}}, {{0, 0, 1}}}}};
  EXPECT_FALSE(comes_in_pieces(options));
}

}  // namespace
}  // namespace lode
