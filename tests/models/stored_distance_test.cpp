// Surfaces within a distance of full resolution, of files larger than the memory limit: held
// against each other in windows, measured here as a whole by a program that knows of none.
#include "lode/mappers/surface_checks.h"
#include "lode/mappers/surface_distance.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/distance_cut.h"
#include "lode/models/diamond/file_extract.h"
#include "tests/models/stored_extract.h"
#include "tests/models/stored_fixtures.h"
#include "tests/models/volume_files.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

using store::TestPath;
using test::stored;
using test::StoredExtract;

/// Hills with some noise, and single bright samples that a coarse cut loses.
Volume spotted_hills(const Index3& dims, double noise) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{1, 0.75, 1.5}};
  grid.origin = {{-40, 12, 300}};
  oracles::Random random(6);
  return oracles::volume_of<std::uint8_t>(grid, [&](const Index3& p) {
    const double hill = 110 + 60 * std::sin(p[0] * 0.07) * std::cos(p[1] * 0.09) +
                        30 * std::sin(p[2] * 0.2 + p[0] * 0.01);
    return random.below(3000) == 0 ? 250 : hill + noise * random.uniform();
  });
}

Index3 several_chunks() { return oracles::trials<Index3>({{800, 40, 32}}, {{860, 17, 14}}); }

/// An infinite distance where one is empty.
void expect_distance(const Surface& surface, const Surface& full, double distance) {
  Progress progress;
  const auto measured = measure_distance(surface, full, {distance / 8, {2}}, progress);
  ASSERT_TRUE(measured);
  EXPECT_LE(measured->lower(), distance + 1e-4);
}

struct Distances {
  double max_distance;
  std::optional<double> max_error{};
  std::optional<double> keep_topology{};
  bool has_estimates = true;  ///< The file's world errors.
};

/// How many triangles the file's surface has, the model's in memory and full resolution's.
std::array<std::size_t, 3> expect_near_of_file(const Volume& volume, double isovalue,
                                               const Distances& within) {
  SCOPED_TRACE(::testing::Message() << within.max_distance);
  const TestPath path("near.lode");
  const std::string lode = stored(path, volume);
  if (!within.has_estimates) test::leave_out(lode, diamond::Kind::worlds);
  ExtractOptions options{.isovalues = {isovalue}, .max_error = 0};
  options.normals = Normals::off;
  StoredExtract full;
  test::extract_stored(lode, options, true, full);
  options.max_error = within.max_error;
  options.max_distance = within.max_distance;
  options.keep_topology = within.keep_topology;
  StoredExtract pieces;
  StoredExtract whole;
  test::extract_stored(lode, options, true, pieces);
  test::extract_stored(lode, options, false, whole);
  if (testing::Test::HasFatalFailure()) return {};
  const DistanceReport& report = pieces.report.distance.value();
  EXPECT_LE(report.proven_distance, within.max_distance);
  EXPECT_EQ(report.full_triangles, full.surface.triangles.size());
  EXPECT_EQ(report.lost_triangles, 0U);
  if (within.max_error) EXPECT_LE(pieces.report.achieved_error, *within.max_error);
  expect_distance(pieces.surface, full.surface, within.max_distance);
  const auto topology = check_topology(pieces.surface, {});
  if (volume.info.nodata == std::nullopt) EXPECT_TRUE(topology.is_clean_manifold());
  if (within.keep_topology)
    EXPECT_EQ(component_types(topology), component_types(check_topology(full.surface, {})));
  return {pieces.surface.triangles.size(), whole.surface.triangles.size(),
          full.surface.triangles.size()};
}

TEST(stored_distance, is_kept_across_chunks) {
  for (const double distance : oracles::trials<std::vector<double>>({0.4, 1, 4}, {1})) {
    const auto [pieces, whole, full] =
        expect_near_of_file(spotted_hills(several_chunks(), 3), 120.5, {distance});
    EXPECT_LT(5 * pieces, 4 * full);
    EXPECT_LT(10 * pieces, 11 * whole) << "windows cost few triangles";
  }
}

TEST(stored_distance, is_kept_by_noise) {
  expect_near_of_file(spotted_hills(several_chunks(), oracles::trials(60.0, 40.0)),
                      oracles::trials(205.5, 190.5), {1.2});
}

TEST(stored_distance, is_looked_for_in_windows_where_only_the_model_fits) {
  const TestPath path("fits.lode");
  const std::string lode =
      stored(path, spotted_hills(oracles::trials<Index3>({{800, 40, 32}}, {{600, 20, 16}}), 3));
  ExtractOptions options{.isovalues = {120.5}};
  options.max_distance = 1.2;
  options.normals = Normals::off;
  Progress progress;
  const auto extract = [&](const Dataset& dataset, std::uint64_t limit) {
    options.memory_limit = limit;
    Surface surface;
    return dataset.extract(options, surface, progress).value().distance.value();
  };
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  const std::uint64_t model = dataset->impl().model_bytes();
  const DistanceReport in_windows = extract(*dataset, model + 1'000'000);
  EXPECT_EQ(in_windows.memory_limit, model + 1'000'000);
  EXPECT_TRUE(dataset->impl().is_in_file());
  const std::uint64_t enough = model + 205 * in_windows.full_triangles + 1;
  const DistanceReport too_tight = extract(*dataset, enough - 2);
  EXPECT_EQ(too_tight.memory_limit, enough - 2);
  const DistanceReport in_memory = extract(*dataset, enough);
  EXPECT_EQ(in_memory.memory_limit, 0U) << "all in memory";
  EXPECT_FALSE(dataset->impl().is_in_file());
  const DistanceReport again = extract(*dataset, enough - 2);
  EXPECT_EQ(again.memory_limit, enough - 2) << "whatever was asked before";
  EXPECT_EQ(again.rounds, too_tight.rounds);
}

TEST(stored_distance, is_kept_between_holes) {
  Volume volume = spotted_hills(several_chunks(), 3);
  volume.info.nodata = 7;
  oracles::Random random(11);
  for (std::uint8_t& sample : oracles::typed_samples<std::uint8_t>(volume))
    if (random.below(3000) == 0) sample = 7;
  expect_near_of_file(volume, 120.5, {1.2});
}

TEST(stored_distance, is_kept_with_other_tolerances) {
  const Volume volume = spotted_hills(several_chunks(), 9);
  const auto alone = expect_near_of_file(volume, 120.5, {1.5});
  const auto with_error = expect_near_of_file(volume, 120.5, {1.5, 6.0});
  EXPECT_GT(with_error[0], alone[0]);
  expect_near_of_file(volume, 120.5, {1.5, {}, 0.0});
}

TEST(stored_distance, is_kept_without_world_errors_in_the_file) {
  const Volume volume = spotted_hills(several_chunks(), 3);
  const auto [pieces, whole, full] =
      expect_near_of_file(volume, 120.5, {.max_distance = 1, .has_estimates = false});
  EXPECT_LT(5 * pieces, 4 * full);
  const auto with_them = expect_near_of_file(volume, 120.5, {.max_distance = 1});
  EXPECT_NE(pieces, with_them[0]) << "it begins elsewhere";
  EXPECT_EQ(full, with_them[2]);
}

TEST(stored_distance, far_below_a_voxel_is_full_resolution) {
  const auto [pieces, whole, full] =
      expect_near_of_file(spotted_hills(several_chunks(), 20), 120.5, {1e-12});
  EXPECT_EQ(pieces, full);
  EXPECT_EQ(whole, full);
}

struct Windows {
  double distance = 1;
  double tolerance = std::numeric_limits<double>::infinity();
  std::uint64_t bytes = 0;  ///< 0: single bricks.
};

/// The whole, held against full resolution as in memory, has nothing left to refine; but proofs
/// try few of the facets near a piece, so one that a window has may not be found again. What has
/// none is measured closely.
void expect_near_in_windows(const Volume& volume, const Windows& windows) {
  SCOPED_TRACE(::testing::Message()
               << volume.info.grid.dims[0] << " x " << volume.info.grid.dims[1] << " within "
               << windows.distance << ", " << windows.bytes << " bytes");
  const TestPath path("windows.lode");
  const diamond::Model<3> model = test::built<3>(volume);
  test::save<3>(model, path.str());
  const auto reader = store::Reader::open(path.str());
  ASSERT_TRUE(reader);
  const auto field = diamond::load_coarse<3>(*reader, *diamond::read_metadata(*reader), {2});
  ASSERT_TRUE(field);
  Progress progress;
  diamond::IsosurfaceQuery query{.isovalue = 120.5, .tolerance = windows.tolerance, .threads = {2}};
  Surface full;
  ASSERT_TRUE(diamond::extract_isosurface<3>(model, {.isovalue = 120.5}, full, progress));
  store::BlockCache blocks(*reader, 1'000'000);
  const auto cut = diamond::find_distance_cut(
      *field, blocks,
      {query, diamond::NodeSet<3>(model.shape), windows.distance, 1'000'000'000, windows.bytes},
      progress);
  ASSERT_TRUE(cut) << cut.error().message;
  EXPECT_EQ(cut->report.n_full_triangles, full.triangles.size());
  EXPECT_EQ(cut->report.n_lost, 0U);
  query.wanted = &cut->nodes;
  Surface surface;
  ASSERT_TRUE(diamond::extract_isosurface<3>(model, query, surface, progress));
  expect_distance(surface, full, windows.distance);
  EXPECT_LT(surface.triangles.size(), full.triangles.size() / 2);
  const diamond::WorldErrors no_guess(model.levels.size());
  const auto again = diamond::find_distance_cut(model, query, windows.distance, no_guess, progress);
  ASSERT_TRUE(again);
  if (again->report.n_nodes == 0) return;
  EXPECT_LE(again->report.n_nodes * 100, cut->report.n_nodes);
  const auto measured = measure_distance(surface, full, {windows.distance / 512, {2}}, progress);
  ASSERT_TRUE(measured);
  EXPECT_LE(measured->upper(), windows.distance);
}

TEST(stored_distance, is_kept_in_windows_of_any_size) {
  const Volume volume = spotted_hills(oracles::trials<Index3>({{310, 17, 36}}, {{290, 12, 33}}),
                                      oracles::trials(20.0, 12.0));
  const bool has_all = oracles::trials(true, false);
  for (const std::uint64_t bytes : {std::uint64_t{0}, std::uint64_t{6'000'000}}) {
    if (has_all || bytes == 0) expect_near_in_windows(volume, {.distance = 1.5, .bytes = bytes});
    if (has_all || bytes > 0)
      expect_near_in_windows(volume, {.distance = 40, .tolerance = 12, .bytes = bytes});
  }
}

/// Leaves as large as bricks, and the data's end at all distances from a part's.
TEST(stored_distance, is_kept_where_the_data_end_beside_a_chunk) {
  for (const std::int32_t n :
       oracles::trials<std::vector<std::int32_t>>({257, 289, 290, 298, 319, 321, 330}, {290}))
    for (const double distance : oracles::trials<std::vector<double>>({3, 60}, {60}))
      expect_near_in_windows(
          spotted_hills(oracles::trials<Index3>({{n, 65, 65}}, {{n, 20, 65}}), 0),
          {.distance = distance});
}

/// `low` up to a step in x and 131 behind it, but for samples that a coarse cut loses.
Volume step_at(std::int32_t x, std::int32_t n, double low, const std::vector<Index3>& spots) {
  RegularGrid grid;
  grid.dims = {{n, 65, 65}};
  return oracles::volume_of<float>(grid, [&](const Index3& p) {
    const bool is_low = p[0] < x;
    if (std::ranges::find(spots, p) != spots.end()) return is_low ? 250.0 : 0.0;
    return is_low ? low : 131.0;
  });
}

/// The cut without the data's end has its surface at 262, near the spot; but that end, less than a
/// brick beyond the part of the first chunk, asks for nodes that move it away.
TEST(stored_distance, is_not_proven_by_what_is_refined_at_the_data_s_end) {
  expect_near_in_windows(step_at(284, 298, 118, {{{254, 32, 32}}}),
                         {.distance = 14, .bytes = 1'000'000'000});
}

/// The first spot is near the cut's surface at 228 until the second, in the next chunk, asks for
/// nodes that move it: farther from the first than bricks are large.
TEST(stored_distance, is_proven_again_where_a_far_surface_moves) {
  expect_near_in_windows(step_at(256, 330, 119, {{{190, 20, 20}}, {{270, 32, 32}}}),
                         {.distance = 40, .bytes = 1'000'000'000});
}

/// Chunks beside each other along all axes, of a grid that is turned and has other steps.
TEST(stored_distance, is_kept_in_windows_beside_each_other_along_all_axes) {
  Volume volume = spotted_hills(oracles::trials<Index3>({{65, 290, 298}}, {{9, 262, 270}}), 0);
  volume.info.grid.spacing = {{0.7, 1.9, 1.1}};
  volume.info.grid.direction.rows = {Vec3d{{0.6, 0, -0.8}}, Vec3d{{0, 1, 0}}, Vec3d{{0.8, 0, 0.6}}};
  expect_near_in_windows(volume, {.distance = 2, .bytes = 9'000'000});
}

TEST(stored_distance, of_several_isovalues_is_counted_together) {
  const TestPath path("several.lode");
  const std::string lode = stored(path, spotted_hills(several_chunks(), 3));
  ExtractOptions options{.isovalues = {120.5, 90.5}, .max_error = 0, .max_distance = 2.0};
  StoredExtract full;
  test::extract_stored(lode, options, true, full);
  ASSERT_TRUE(full.report.distance);
  EXPECT_EQ(full.report.distance->full_triangles, full.surface.triangles.size());
  EXPECT_EQ(full.report.distance->proven_distance, 0);
  options.max_error.reset();
  StoredExtract near;
  test::extract_stored(lode, options, true, near);
  EXPECT_EQ(near.report.distance->full_triangles, full.surface.triangles.size());
  EXPECT_LT(near.surface.triangles.size(), full.surface.triangles.size());
  expect_distance(near.surface, full.surface, 2);
  Progress progress;
  EXPECT_EQ(check_self_intersections(near.surface, {2}, progress)->n_intersections, 0U);
}

TEST(stored_distance, stops_when_cancelled) {
  const TestPath path("cancelled.lode");
  const std::string lode = stored(path, spotted_hills(several_chunks(), 3));
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  for (const char* phase : {"proving the distance", "finding critical nodes"}) {
    Progress* running = nullptr;
    Progress progress([&](std::string_view now, double, std::uint64_t) {
      if (now == phase) running->cancel();
    });
    running = &progress;
    ExtractOptions options{.isovalues = {120.5}, .max_distance = 1.0, .keep_topology = 0};
    options.memory_limit = dataset->impl().chunk_bytes();
    Surface surface;
    const auto stopped = dataset->extract(options, surface, progress);
    ASSERT_FALSE(stopped) << phase;
    EXPECT_EQ(stopped.error().message, cancelled_error().message);
  }
}

TEST(stored_distance, gives_the_same_surface_for_any_number_of_threads) {
  const TestPath path("threads.lode");
  const std::string lode = stored(path, spotted_hills(several_chunks(), 6));
  ExtractOptions options{.isovalues = {120.5}, .max_distance = 1.0, .threads = {1}};
  StoredExtract expected;
  test::extract_stored(lode, options, true, expected);
  for (const int threads : oracles::trials<std::vector<int>>({2, 5}, {5})) {
    StoredExtract got;
    options.threads = {threads};
    test::extract_stored(lode, options, true, got);
    EXPECT_TRUE(got.surface.positions == expected.surface.positions);
    EXPECT_TRUE(got.surface.triangles == expected.surface.triangles);
  }
}

/// Which repeats the query, with the limit that says in which windows.
TEST(stored_distance, passes_verification) {
  const TestPath path("verified.lode");
  const std::string lode = stored(path, spotted_hills(several_chunks(), 6));
  ExtractOptions options{.isovalues = {120.5}, .max_distance = 1.0};
  StoredExtract got;
  test::extract_stored(lode, options, true, got);
  const auto dataset = Dataset::open(lode, {2});
  ASSERT_TRUE(dataset);
  options.memory_limit = dataset->impl().chunk_bytes();
  Progress progress;
  const auto verified = dataset->verify_surface(got.surface, options, progress);
  ASSERT_TRUE(verified) << verified.error().message;
  for (const VerifyReport::Check& check : verified->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

TEST(stored_distance, says_so_where_its_nodes_do_not_fit) {
  const TestPath path("nodes.lode");
  test::save<3>(test::built<3>(spotted_hills({{300, 40, 32}}, 6)), path.str());
  const auto reader = store::Reader::open(path.str());
  const auto field = diamond::load_coarse<3>(*reader, *diamond::read_metadata(*reader), {2});
  store::BlockCache blocks(*reader, 1'000'000);
  Progress progress;
  const auto refused = diamond::find_distance_cut(
      *field, blocks,
      {{.isovalue = 120.5, .tolerance = 1e9}, diamond::NodeSet<3>(field->shape), 1.0, 10'000, 0},
      progress);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("max_distance"), std::string::npos);
}

}  // namespace
}  // namespace lode
