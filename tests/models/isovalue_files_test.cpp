// Surfaces of several isovalues in files of their own lie in one cut, as those of one file do.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "lode/api/dataset_impl.h"
#include "lode/api/files.h"
#include "lode/mappers/self_intersections.h"
#include "lode/mappers/surface_match.h"
#include "tests/models/stored_fixtures.h"
#include "tests/models/volume_files.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

using store::TestPath;
using test::stored;

/// Isovalues nearer to each other than a coarse surface is to where it should be.
const std::vector<double> kNearIsovalues{120.5, 112.5, 500, 128.5};

Volume rough_hills() {
  RegularGrid grid;
  grid.dims = oracles::trials<Index3>({{262, 18, 16}}, {{262, 12, 11}});
  grid.spacing = {{1, 0.75, 1.5}};
  oracles::Random random(6);
  return oracles::volume_of<std::uint8_t>(grid, [&](const Index3& p) {
    return 115 + 60 * std::sin(p[0] * 0.07) * std::cos(p[1] * 0.09) +
           30 * std::sin(p[2] * 0.2 + p[0] * 0.01) + 9 * random.uniform(-1, 1);
  });
}

SurfaceWriteOptions no_note(const ExtractReport&, double) { return {}; }

std::vector<std::string> paths_of_isovalues(const std::string& stem, const std::string& extension) {
  std::vector<std::string> paths;
  for (const double isovalue : kNearIsovalues)
    paths.push_back(fmt::format("{}-{}{}", stem, isovalue, extension));
  return paths;
}

std::uint64_t crossings_of(const Surface& surface) {
  Progress progress;
  return check_self_intersections(surface, {2}, progress)->n_intersections;
}

/// Cells of `files` are those of `whole`, at each isovalue.
void expect_parts(const Surface& whole, const std::vector<std::string>& paths) {
  const auto files = read_isovalue_files(paths, kNearIsovalues);
  ASSERT_TRUE(files) << files.error().message;
  EXPECT_EQ(files->triangles.size(), whole.triangles.size());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const auto one = read_surface(paths[i]);
    ASSERT_TRUE(one) << one.error().message;
    Surface part = whole;
    std::erase_if(part.triangles, [&](const auto& t) {
      return whole.isovalues[t[0]] != static_cast<float>(kNearIsovalues[i]);
    });
    EXPECT_TRUE(match_surfaces(part, *one, 0x1p-30).is_same()) << paths[i];
    EXPECT_EQ(part.triangles.empty(), kNearIsovalues[i] == 500);
  }
  EXPECT_EQ(crossings_of(*files), 0U);
  for (const std::string& path : paths) std::filesystem::remove(path);
}

/// How many pairs of triangles meet where each isovalue is extracted by itself.
std::uint64_t crossings_apart(const Dataset& dataset, ExtractOptions options) {
  Progress progress;
  Surface all;
  SurfaceCollector collector(all);
  for (const double isovalue : kNearIsovalues) {
    options.isovalues = {isovalue};
    SurfacePiece piece;
    EXPECT_TRUE(dataset.extract(options, piece.surface, progress));
    piece.first_new = collector.n_vertices();
    EXPECT_TRUE(collector.add(std::move(piece)));
  }
  return crossings_of(all);
}

/// From memory and from a file whose model is over the memory limit.
void expect_one_cut(ExtractOptions options) {
  options.isovalues = kNearIsovalues;
  const TestPath path("near.lode");
  const std::string lode = stored(path, rough_hills());
  for (const bool is_limited : {false, true}) {
    SCOPED_TRACE(is_limited);
    const auto dataset = Dataset::open(lode, {2});
    ASSERT_TRUE(dataset);
    options.memory_limit = is_limited ? dataset->impl().chunk_bytes() : 0;
    Progress progress;
    if (!is_limited) ASSERT_TRUE(dataset->load(progress));
    Surface whole;
    const auto expected = dataset->extract(options, whole, progress);
    ASSERT_TRUE(expected) << expected.error().message;
    for (const char* const extension : {".stl", ".obj"}) {
      if (is_limited && extension == std::string_view(".obj")) continue;  // comes whole
      SCOPED_TRACE(extension);
      const auto paths = paths_of_isovalues(lode, extension);
      const auto together = are_extracted_together(*dataset, options, paths.front(), progress);
      ASSERT_TRUE(together && *together);
      const auto report = extract_to_files(*dataset, options, paths, no_note, progress);
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_EQ(report->triangles, expected->triangles);
      EXPECT_EQ(report->unmet, (std::vector<double>{500}));
      expect_parts(whole, paths);
    }
    if (!is_limited) EXPECT_GT(crossings_apart(*dataset, options), 0U) << "happens by itself";
  }
}

TEST(isovalue_files, share_a_cut_within_a_distance) {
  expect_one_cut({.max_distance = 3, .threads = {2}});
}

TEST(isovalue_files, share_a_cut_that_keeps_their_topology) {
  expect_one_cut({.max_error = 60, .keep_topology = 0, .threads = {2}});
}

TEST(isovalue_files, are_simplified_together) {
  expect_one_cut(
      {.max_error = 0, .simplify = Simplify::edges, .simplify_distance = 1.5, .threads = {2}});
}

TEST(isovalue_files, are_each_extracted_alone_from_memory_where_that_is_the_same) {
  const TestPath path("plain.lode");
  const std::string lode = stored(path, rough_hills());
  const ExtractOptions options{.isovalues = kNearIsovalues, .max_error = 20, .threads = {2}};
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  Progress progress;
  const auto of_file = are_extracted_together(*dataset, options, "a.stl", progress);
  ASSERT_TRUE(of_file);
  EXPECT_TRUE(*of_file) << "read once, written piece by piece";
  EXPECT_FALSE(are_extracted_together(*dataset, options, "a.obj", progress).value());
  ASSERT_TRUE(dataset->load(progress));
  EXPECT_FALSE(are_extracted_together(*dataset, options, "a.stl", progress).value());
  ExtractOptions in_band = options;
  in_band.simplify = Simplify::edges;
  EXPECT_FALSE(are_extracted_together(*dataset, in_band, "a.stl", progress).value());
}

TEST(isovalue_files, are_read_once_from_a_file_and_hold_what_each_alone_has) {
  const TestPath path("once.lode");
  const std::string lode = stored(path, rough_hills());
  const ExtractOptions options{.isovalues = kNearIsovalues, .max_error = 20, .threads = {2}};
  Progress progress;
  const auto paths = paths_of_isovalues(lode, ".stl");
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  const auto all = extract_to_files(*dataset, options, paths, no_note, progress);
  ASSERT_TRUE(all) << all.error().message;
  std::uint64_t bytes_apart = 0;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    ExtractOptions alone = options;
    alone.isovalues = {kNearIsovalues[i]};
    const auto again = Dataset::open(lode, {2});
    Surface expected;
    const auto report = again->extract(alone, expected, progress);
    ASSERT_TRUE(report);
    bytes_apart += report->bytes_read;
    const auto file = read_surface(paths[i]);
    ASSERT_TRUE(file);
    EXPECT_TRUE(match_surfaces(expected, *file, 0x1p-30).is_same()) << paths[i];
    std::filesystem::remove(paths[i]);
  }
  EXPECT_LT(all->bytes_read, bytes_apart / 2);
}

TEST(isovalue_files, take_isovalues_that_float32_does_not_tell_apart) {
  const TestPath path("equal.lode");
  const std::string lode = stored(path, rough_hills());
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  Progress progress;
  const ExtractOptions options{.isovalues = {120, 120 + 1e-9}, .max_distance = 2};
  const std::vector<std::string> paths{lode + "-a.stl", lode + "-b.stl"};
  const auto report = extract_to_files(*dataset, options, paths, no_note, progress);
  ASSERT_TRUE(report) << report.error().message;
  std::size_t n = 0;
  for (const std::string& written : paths) {
    n += read_surface(written).value().triangles.size();
    std::filesystem::remove(written);
  }
  EXPECT_EQ(n, report->triangles);
  // One is a file of its own, too.
  const std::vector<std::string> one{lode + "-one.stl"};
  for (const std::uint64_t limit : {std::uint64_t{0}, std::uint64_t{2'000'000}}) {
    const auto alone =
        extract_to_files(*dataset, {.isovalues = {120}, .max_error = 2.0, .memory_limit = limit},
                         one, no_note, progress);
    ASSERT_TRUE(alone) << alone.error().message;
    EXPECT_EQ(read_surface(one[0]).value().triangles.size(), alone->triangles);
  }
  std::filesystem::remove(one[0]);
  EXPECT_TRUE(check_isovalues_of(paths[0], options.isovalues));
  EXPECT_TRUE(check_isovalues_of("a.ply", options.isovalues));
  EXPECT_FALSE(check_isovalues_of("a.glb", options.isovalues));
  EXPECT_TRUE(check_isovalues_of("a.glb", {120, 121}));
}

TEST(isovalue_files, refuse_to_be_read_with_other_isovalues_than_files) {
  const std::vector<std::string> paths{"a.stl"};
  EXPECT_FALSE(read_isovalue_files(paths, kNearIsovalues));
}

}  // namespace
}  // namespace lode
