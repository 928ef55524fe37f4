// Surfaces that go from a model's file to a surface file piece by piece.
#include <cstdio>
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

std::string bytes_at(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Crosses a border of chunks; at places its central differences vanish, and normals with them.
Volume wavy(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  return oracles::volume_of<std::uint8_t>(grid, [](const Index3& p) {
    const bool is_checkered = p[0] < 20;
    return is_checkered ? 100.0 + 40 * ((p[0] + p[1] + p[2]) % 2)
                        : 120 + 50 * std::sin(0.11 * p[0]) * std::cos(0.07 * p[1] + 0.05 * p[2]);
  });
}

struct PiecesCase {
  const char* extension;
  std::vector<double> isovalues;
  Orientation orientation = Orientation::from_lower_values;
  Normals normals = Normals::on;
};

/// Of one dataset piece by piece, of another the surface first.
void expect_same_bytes(const std::string& lode, const PiecesCase& c, double tolerance) {
  const std::string streamed = lode + "-streamed" + c.extension;
  const std::string whole = lode + "-whole" + c.extension;
  ExtractOptions options{.isovalues = c.isovalues,
                         .max_error = tolerance,
                         .orientation = c.orientation,
                         .normals = c.normals};
  const auto note = [](const ExtractReport& report) -> SurfaceWriteOptions {
    return {.comment = fmt::format("{} triangles", report.triangles)};
  };
  Progress progress;
  const auto closed = Dataset::open(lode, {2});
  ASSERT_TRUE(closed);
  ASSERT_TRUE(closed->comes_in_pieces(options, progress).value());
  const auto report = extract_to_file(*closed, options, streamed, note, progress);
  ASSERT_TRUE(report) << report.error().message;

  const auto loaded = Dataset::open(lode, {2});
  ASSERT_TRUE(loaded && loaded->load(progress));
  ASSERT_FALSE(loaded->comes_in_pieces(options, progress).value());
  Surface surface;
  const auto expected = loaded->extract(options, surface, progress);
  ASSERT_TRUE(expected) << expected.error().message;
  ASSERT_TRUE(write_surface(whole, surface, note(*expected), progress));
  EXPECT_EQ(report->triangles, expected->triangles);
  EXPECT_EQ(report->lines, expected->lines);
  EXPECT_EQ(report->vertices, expected->vertices);
  EXPECT_EQ(report->achieved_error, expected->achieved_error);
  EXPECT_EQ(report->unmet, expected->unmet);
  EXPECT_GT(report->vertices, 0U);
  EXPECT_TRUE(bytes_at(streamed) == bytes_at(whole)) << c.extension;
  std::filesystem::remove(streamed);
  std::filesystem::remove(whole);
}

TEST(surface_pieces, make_the_file_of_the_whole_surface) {
  const TestPath path("wavy.lode");
  const std::string lode =
      stored(path, wavy(oracles::trials<Index3>({{270, 40, 36}}, {{270, 24, 20}})));
  for (const PiecesCase& c :
       {PiecesCase{".ply", {120.5}}, PiecesCase{".stl", {120.5}},
        PiecesCase{".vtp", {120.5, 500, 90.25, 130}},
        PiecesCase{".ply", {110.5, 140.5}, Orientation::from_higher_values},
        PiecesCase{".vtp", {120.5}, Orientation::from_higher_values, Normals::off},
        PiecesCase{".obj", {120.5}}})
    expect_same_bytes(lode, c, 1.5);
}

TEST(surface_pieces, make_the_contour_lines_of_an_image) {
  const TestPath path("image.lode");
  const std::string lode = stored(path, wavy({{2100, 90, 1}}));
  expect_same_bytes(lode, {".vtp", {120.5, 90}}, 2);
  expect_same_bytes(lode, {".ply", {120.5}}, 2);
}

TEST(surface_pieces, make_the_file_of_a_surface_between_holes) {
  const TestPath path("holes.lode");
  Volume volume = wavy(oracles::trials<Index3>({{270, 40, 36}}, {{270, 24, 20}}));
  volume.info.nodata = 7;
  oracles::Random random(11);
  for (std::uint8_t& sample : oracles::typed_samples<std::uint8_t>(volume))
    if (random.below(40) == 0) sample = 7;
  const std::string lode = stored(path, volume);
  expect_same_bytes(lode, {".ply", {120.5}}, 3);
  expect_same_bytes(lode, {".vtp", {120.5, 90.25}, Orientation::from_higher_values}, 3);
  expect_same_bytes(lode, {".stl", {120.5}}, 30);
}

TEST(surface_pieces, need_memory_for_a_chunk_at_least) {
  const TestPath path("limit.lode");
  const std::string lode = stored(path, wavy({{560, 80, 70}}));
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  ExtractOptions options{.isovalues = {120.5}, .max_error = 20, .memory_limit = 2'000'000};
  Surface surface;
  Progress progress;
  const auto refused = dataset->extract(options, surface, progress);
  ASSERT_FALSE(refused);
  const std::string& message = refused.error().message;
  int megabytes = 0;
  ASSERT_EQ(std::sscanf(message.c_str(), "expected a memory limit of at least %d MB", &megabytes),
            1)
      << message;
  EXPECT_GT(megabytes, 2);
  options.memory_limit = static_cast<std::uint64_t>(megabytes) * 1'000'000;
  EXPECT_TRUE(dataset->extract(options, surface, progress));
  EXPECT_FALSE(surface.is_empty());
}

/// Chunk by chunk and all in memory; extraction says the same.
void expect_same_counts(const std::string& lode, double max_error) {
  SCOPED_TRACE(::testing::Message() << lode << " at " << max_error);
  const std::vector<double> isovalues{120.5, 500, 90};
  const auto limited = Dataset::open(lode, {2});
  const auto free = Dataset::open(lode, {2});
  ASSERT_TRUE(limited && free);
  const std::uint64_t limit = limited->impl().chunk_bytes();
  ASSERT_LT(limit, limited->impl().model_bytes());
  CountOptions options{.isovalues = isovalues, .max_error = max_error, .threads = {2}};
  Progress progress;
  const auto whole = free->count(options, progress);
  ASSERT_FALSE(free->impl().is_in_file());
  options.memory_limit = limit;
  const auto pieces = limited->count(options, progress);
  ASSERT_TRUE(whole && pieces);
  EXPECT_TRUE(limited->impl().is_in_file()) << "all of it was loaded";
  EXPECT_GT(limited->impl().reads().n_blocks, 0U);
  EXPECT_EQ(pieces->max_error, max_error);
  for (std::size_t i = 0; i < isovalues.size(); ++i) {
    Surface surface;
    ASSERT_TRUE(
        free->extract({.isovalues = {isovalues[i]}, .max_error = max_error}, surface, progress));
    for (const CountReport& report : {*whole, *pieces}) {
      EXPECT_EQ(report.counts[i].isovalue, isovalues[i]);
      EXPECT_EQ(report.counts[i].triangles, surface.triangles.size());
      EXPECT_EQ(report.counts[i].lines, surface.lines.size());
      EXPECT_EQ(report.counts[i].vertices, surface.positions.size());
    }
    EXPECT_EQ(surface.is_empty(), isovalues[i] == 500);
  }
}

TEST(surface_pieces, are_counted_where_the_model_does_not_fit) {
  const TestPath path("counted.lode");
  for (const Index3& dims : {Index3{{800, 40, 20}}, Index3{{10000, 100, 1}}}) {
    Volume volume = wavy(dims);
    std::string lode = stored(path, volume);
    for (const double max_error : {0.0, 1.5}) expect_same_counts(lode, max_error);
    volume.info.nodata = 7;
    oracles::Random random(11);
    for (std::uint8_t& sample : oracles::typed_samples<std::uint8_t>(volume))
      if (random.below(500) == 0) sample = 7;
    lode = stored(path, volume);
    for (const double max_error : {0.0, 1.5}) expect_same_counts(lode, max_error);
  }
}

TEST(surface_pieces, have_normals_everywhere) {
  const TestPath path("checkered.lode");
  const std::string lode = stored(path, wavy({{40, 24, 262}}));
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  Surface surface;
  SurfaceCollector collector(surface);
  Progress progress;
  ASSERT_TRUE(dataset->extract({.isovalues = {120.5}, .max_error = 1}, collector, progress));
  ASSERT_EQ(surface.normals.size(), surface.positions.size());
  std::size_t n_zero = 0;
  for (const Vec3f& n : surface.normals) n_zero += n == Vec3f{} ? 1 : 0;
  EXPECT_EQ(n_zero, 0U);
}

TEST(surface_pieces, that_an_edit_needs_together_come_as_one) {
  const TestPath path("edited.lode");
  const std::string lode = stored(path, wavy({{60, 50, 40}}));
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  ExtractOptions options{.isovalues = {120.5}, .max_error = 1};
  options.min_component = 100;
  Progress progress;
  EXPECT_FALSE(dataset->comes_in_pieces(options, progress).value());
  Surface expected;
  Surface got;
  SurfaceCollector collector(got);
  ASSERT_TRUE(dataset->extract(options, expected, progress));
  ASSERT_TRUE(dataset->extract(options, collector, progress));
  EXPECT_TRUE(got.positions == expected.positions && got.triangles == expected.triangles);
}

}  // namespace
}  // namespace lode
