// The style of cubes from files, chunk by chunk, is what it is from memory.
#include <algorithm>
#include <atomic>
#include <thread>

#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/file_extract.h"
#include "tests/models/stored_extract.h"
#include "tests/models/stored_fixtures.h"
#include "tests/models/volume_files.h"
#include "tests/oracles/tetra_surfaces.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

using store::TestPath;
using test::stored;
using test::StoredExtract;

/// Waves through all chunks, with noise whose cells are far from cubes here and there.
Volume noisy_cubes(const Index3& dims, ScalarType type, test::Holes holes) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{0.5, 1.0, 0.75}};
  oracles::Random random(5);
  return visit_scalar_type(type, [&]<typename T>() {
    Volume volume = oracles::volume_of<T>(grid, [&](const Index3& p) {
      return 110 + 30 * std::sin(0.13 * p[0] + 0.05 * p[2]) * std::cos(0.12 * p[1] + 0.1 * p[2]) +
             (p[0] % 64 < 24 ? random.uniform(-20, 20) : 0.0);
    });
    if (holes == test::Holes::none) return volume;
    if (!std::is_floating_point_v<T>) volume.info.nodata = 3;
    for (T& sample : oracles::typed_samples<T>(volume))
      if (random.below(9000) == 0)
        sample = std::is_floating_point_v<T> ? std::numeric_limits<T>::quiet_NaN() : T(3);
    return volume;
  });
}

ExtractOptions cubes_within(double max_error, std::vector<double> isovalues = {110.5}) {
  ExtractOptions options{.isovalues = std::move(isovalues), .max_error = max_error};
  options.style = SurfaceStyle::cubes;
  options.deviation = Deviation::measured;
  options.threads = {2};
  return options;
}

void expect_as_in_memory(const std::string& lode, const ExtractOptions& options) {
  SCOPED_TRACE(*options.max_error);
  StoredExtract pieces;
  StoredExtract whole;
  test::extract_stored(lode, options, true, pieces);
  test::extract_stored(lode, options, false, whole);
  if (testing::Test::HasFatalFailure()) return;
  EXPECT_GT(whole.surface.triangles.size(), 1000U);
  EXPECT_EQ(pieces.surface.positions.size(), whole.surface.positions.size());
  EXPECT_TRUE(oracles::sorted_triangles(pieces.surface) ==
              oracles::sorted_triangles(whole.surface));
  EXPECT_EQ(pieces.report.style_error, whole.report.style_error);
  EXPECT_EQ(pieces.report.style_distance, whole.report.style_distance);
  if (*options.max_error > 0) EXPECT_LE(pieces.report.style_error, *options.max_error);
  if (options.isovalues.size() == 1)
    EXPECT_TRUE(check_topology(pieces.surface, {}).is_clean_manifold());
}

/// Cells with a corner in what is left out keep their tetrahedra, in each chunk.
TEST(stored_cubes, without_what_does_not_persist_are_those_of_memory) {
  const TestPath path("persistent_cubes.lode");
  const std::string lode =
      stored(path, noisy_cubes({{1100, 18, 14}}, ScalarType::uint8, test::Holes::none));
  ExtractOptions options = cubes_within(0);
  options.keep_topology = 12;
  for (const double distance : {0.2, 1e6}) {
    options.style_distance = distance;
    expect_as_in_memory(lode, options);
  }
}

/// Whose cells beside other chunks matter to these: chunks end at multiples of 256.
TEST(stored_cubes, are_those_of_memory) {
  const TestPath path("cubes.lode");
  const bool is_slow = oracles::trials(true, false);
  std::vector<std::pair<Index3, ScalarType>> volumes{{{{1100, 18, 14}}, ScalarType::uint8},
                                                     {{{17, 1100, 14}}, ScalarType::int16},
                                                     {{{15, 18, 1300}}, ScalarType::float32}};
  if (is_slow) volumes.push_back({{{530, 540, 17}}, ScalarType::uint8});  // that meet at edges
  for (const auto& [dims, type] : volumes)
    for (const test::Holes holes : {test::Holes::none, test::Holes::some}) {
      if (!is_slow && (type == ScalarType::int16) != (holes == test::Holes::some)) continue;
      SCOPED_TRACE(::testing::Message() << dims[0] << " " << static_cast<int>(holes));
      const std::string lode = stored(path, noisy_cubes(dims, type, holes));
      for (const double max_error : {0.0, 4.0}) expect_as_in_memory(lode, cubes_within(max_error));
      for (const double max_error : {0.5, 1000.0})
        if (is_slow) expect_as_in_memory(lode, cubes_within(max_error));
    }
}

TEST(stored_cubes, of_several_isovalues_come_one_after_the_other) {
  const TestPath path("several_cubes.lode");
  const std::string lode =
      stored(path, noisy_cubes(oracles::trials<Index3>({{1100, 18, 14}}, {{860, 18, 14}}),
                               ScalarType::uint8, test::Holes::some));
  expect_as_in_memory(lode, cubes_within(3, {120.5, 95.5, 110.5}));
}

/// In one pass; one of them is not wanted at all, one no more after its first piece.
TEST(stored_cubes, of_several_isovalues_come_side_by_side) {
  const TestPath path("one_pass.lode");
  const std::string lode =
      stored(path, noisy_cubes(oracles::trials<Index3>({{1100, 18, 14}}, {{860, 18, 14}}),
                               ScalarType::uint8, test::Holes::some));
  const std::vector<double> isovalues{90.5, 100.5, 110.5, 120.5};
  const auto reader = store::Reader::open(lode);
  ASSERT_TRUE(reader);
  const auto field = diamond::load_coarse<3>(*reader, *diamond::read_metadata(*reader), {2});
  ASSERT_TRUE(field);
  store::BlockCache blocks(*reader, 1'000'000);
  std::array<Surface, 4> surfaces;
  std::vector<SurfaceCollector> sinks(surfaces.begin(), surfaces.end());
  std::atomic<int> n_elsewhere = 0;  // Sinks may go while they are asked for.
  const auto sink_of = [&, own = std::this_thread::get_id()](std::size_t i) -> SurfaceSink* {
    if (std::this_thread::get_id() != own) ++n_elsewhere;
    if (i == 1 || (i == 2 && !surfaces[2].triangles.empty())) return nullptr;
    return &sinks[i];
  };
  Progress progress;
  const auto report = diamond::extract_from_file<3>(
      *field, blocks, diamond::IsovalueList::of(isovalues),
      {.tolerance = 3, .style = SurfaceStyle::cubes, .with_deviation = true, .threads = {2}},
      sink_of, progress);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(n_elsewhere, 0);
  EXPECT_LE(report->deviation.error, 3);
  for (const std::size_t i : {0U, 2U, 3U}) {
    StoredExtract alone;
    test::extract_stored(lode, cubes_within(3, {isovalues[i]}), false, alone);
    if (i != 2)
      EXPECT_TRUE(oracles::sorted_triangles(surfaces[i]) ==
                  oracles::sorted_triangles(alone.surface));
    else
      EXPECT_LT(surfaces[i].triangles.size(), alone.surface.triangles.size());
    EXPECT_LE(alone.report.style_error, 3);
  }
  EXPECT_TRUE(surfaces[1].is_empty());
}

TEST(stored_cubes, are_the_same_for_any_threads) {
  const TestPath path("threads_cubes.lode");
  const std::string lode =
      stored(path, noisy_cubes(oracles::trials<Index3>({{1100, 18, 14}}, {{860, 18, 14}}),
                               ScalarType::uint8, test::Holes::some));
  ExtractOptions options = cubes_within(3);
  options.threads = {1};
  StoredExtract one;
  test::extract_stored(lode, options, true, one);
  for (const int threads : oracles::trials<std::vector<int>>({2, 5}, {5})) {
    options.threads = {threads};
    StoredExtract more;
    test::extract_stored(lode, options, true, more);
    EXPECT_TRUE(more.surface.positions == one.surface.positions);
    EXPECT_TRUE(more.surface.triangles == one.surface.triangles);
    EXPECT_TRUE(more.surface.normals == one.surface.normals);
    EXPECT_EQ(more.report.style_distance, one.report.style_distance);
  }
}

}  // namespace
}  // namespace lode
