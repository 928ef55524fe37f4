// The topology of surfaces from files, chunk by chunk, is kept as from memory.
#include "lode/api/dataset_impl.h"
#include "lode/mappers/surface_match.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/critical_nodes.h"
#include "tests/models/stored_extract.h"
#include "tests/models/stored_fixtures.h"
#include "tests/models/volume_files.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

using diamond::CriticalNodes;
using diamond::CriticalQuery;
using store::TestPath;
using test::stored;
using test::StoredExtract;

constexpr double kAnyError = 1e9;

/// Waves with noise that has pieces, tunnels and threads of all sizes.
/// n_rough: of 90 layers, how many have noise.
Volume rough_waves(const Index3& dims, ScalarType type, std::uint64_t seed = 3,
                   std::int32_t n_rough = 50) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{1, 0.5, 2}};
  oracles::Random random(seed);
  return visit_scalar_type(type, [&]<typename T>() {
    return oracles::volume_of<T>(grid, [&](const Index3& p) {
      return 120 + 40 * std::sin(0.11 * p[0]) * std::cos(0.09 * p[1]) +
             20 * std::sin(0.3 * p[2] + 0.02 * p[0]) +
             (p[0] % 90 < n_rough ? random.uniform(-25, 25) : 0.0);
    });
  });
}

void add_holes(Volume& volume) {
  oracles::Random random(11);
  const bool is_float = is_floating(volume.info.type);
  if (!is_float) volume.info.nodata = 7;
  visit_scalar_type(volume.info.type, [&]<typename T>() {
    for (T& sample : oracles::typed_samples<T>(volume))
      if (random.below(2000) == 0)
        sample = is_float ? std::numeric_limits<T>::quiet_NaN() : static_cast<T>(7);
  });
}

void expect_same_nodes(const CriticalNodes& got, const CriticalNodes& expected,
                       const Index3& dims) {
  EXPECT_EQ(got.n_critical, expected.n_critical);
  EXPECT_EQ(got.n_nodes, expected.n_nodes);
  std::size_t n_different = 0;
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (std::int32_t x = 0; x < dims[0]; x += 64) {
        const Index3 first{{x, y, z}};
        n_different += got.nodes.row(first, 64) != expected.nodes.row(first, 64) ? 1 : 0;
      }
  EXPECT_EQ(n_different, 0U);
}

void expect_found_in_file(const Volume& volume, const CriticalQuery& query) {
  SCOPED_TRACE(::testing::Message() << volume.info.grid.dims[0] << " " << query.persistence);
  const TestPath path("topology.lode");
  const diamond::Model<3> model = test::built<3>(volume);
  test::save<3>(model, path.str());
  const auto reader = store::Reader::open(path.str());
  ASSERT_TRUE(reader);
  const auto metadata = diamond::read_metadata(*reader);
  ASSERT_TRUE(metadata);
  const auto field = diamond::load_coarse<3>(*reader, *metadata, {2});
  ASSERT_TRUE(field) << field.error().message;
  store::BlockCache blocks(*reader, 1'000'000);
  Progress progress;
  const auto expected = diamond::find_critical_nodes(model, query, progress);
  const auto got = diamond::find_critical_nodes(*field, blocks, query, progress);
  ASSERT_TRUE(expected && got) << (got ? "" : got.error().message);
  EXPECT_GT(expected->n_critical, 100U);
  expect_same_nodes(*got, *expected, model.shape.dims);
}

TEST(stored_topology, has_the_critical_nodes_of_the_model_in_memory) {
  for (const auto& [dims, type] : {std::pair{Index3{{300, 40, 32}}, ScalarType::uint8},
                                   {{{33, 270, 65}}, ScalarType::int16},
                                   {{{40, 35, 257}}, ScalarType::float32},
                                   {{{513, 17, 20}}, ScalarType::float64}})
    for (const double persistence : oracles::trials<std::vector<double>>({0.0, 8.0}, {8.0})) {
      Volume volume = rough_waves(dims, type);
      const CriticalQuery query{120.3, persistence, {2}};
      CriticalQuery within = query;
      within.tolerance = 25;
      expect_found_in_file(volume, query);
      if (persistence > 0) expect_found_in_file(volume, within);
      add_holes(volume);
      expect_found_in_file(volume, query);
    }
}

/// By brute force: all nodes of all levels, whose rings are walked in world order of the star's
/// vertices, without bricks or rows.
TEST(stored_topology, misses_no_node_that_brute_force_finds) {
  const Index3 dims{{70, 41, 37}};
  const Volume volume = rough_waves(dims, ScalarType::uint8, 9);
  const diamond::Model<3> model = test::built<3>(volume);
  const double c = 120.5;
  Progress progress;
  const auto found = diamond::find_critical_nodes(model, {c, 0, {2}}, progress);
  ASSERT_TRUE(found);
  std::uint64_t n_critical = 0;
  const auto side = [&](const Index3& p) { return model.value(p) >= c; };
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (std::int32_t x = 0; x < dims[0]; ++x) {
        const Index3 p{{x, y, z}};
        if (diamond::common_exponent<3>(p) >= model.shape.n_levels) continue;
        const auto node = diamond::diamond_at<3>(p);
        const auto ends = diamond::axis_ends<3>(node);
        if (!model.shape.is_sample(ends[0]) || !model.shape.is_sample(ends[1])) continue;
        if (side(ends[0]) == side(p) || side(ends[1]) == side(p)) continue;
        // Vertices round the axis in pairs that share a simplex: a graph of one or two arcs.
        std::vector<Index3> ring;
        for (const Index3& v : diamond::domain_vertices<3>(node))
          if (v != ends[0] && v != ends[1] && model.shape.is_sample(v)) ring.push_back(v);
        const auto are_neighbours = [&](const Index3& a, const Index3& b) {
          // Those of a simplex: one has the coordinates of the face that the other moves on from.
          std::int32_t n_apart = 0;
          std::int32_t largest = 0;
          for (std::size_t i = 0; i < 3; ++i) {
            n_apart += a[i] != b[i] ? 1 : 0;
            largest = std::max(largest, std::abs(a[i] - b[i]));
          }
          const auto n_odd = 3 - node.tier;
          if (n_odd == 3) return n_apart == 1;                         // corners of a cube
          if (n_odd == 2) return n_apart == 3 && largest == node.h();  // corners and cube centres
          return n_apart == 1 && largest == node.h();                  // face and cube centres
        };
        int n_changes = 0;
        int n_pairs = 0;
        for (std::size_t i = 0; i < ring.size(); ++i)
          for (std::size_t j = i + 1; j < ring.size(); ++j)
            if (are_neighbours(ring[i], ring[j])) {
              ++n_pairs;
              n_changes += side(ring[i]) != side(ring[j]) ? 1 : 0;
            }
        const bool is_closed = n_pairs == static_cast<int>(ring.size());
        if (n_changes == (is_closed ? 2 : 1)) continue;
        ++n_critical;
        EXPECT_TRUE(found->nodes.contains(p)) << x << " " << y << " " << z;
      }
  EXPECT_EQ(found->n_critical, n_critical);
  EXPECT_GT(n_critical, 1000U);
}

ComponentTypes types_of(const Surface& surface) {
  return component_types(check_topology(surface, {}));
}

/// Of several chunks.
Index3 long_dims() { return oracles::trials<Index3>({{800, 40, 32}}, {{860, 17, 14}}); }

/// From a file that the memory limit does not let in, and from memory.
TEST(stored_topology, is_kept_in_the_surface_that_memory_gives) {
  const TestPath path("kept.lode");
  for (const bool has_holes : {false, true})
    for (const double persistence : {0.0, 10.0}) {
      // In noise what is kept of regions that do not persist is more than a limit leaves, below
      // which a model so small does not fit.
      Volume volume = rough_waves(long_dims(), ScalarType::uint8, 3, persistence > 0 ? 25 : 50);
      if (has_holes) add_holes(volume);
      const std::string lode = stored(path, volume);
      for (const double max_error : oracles::trials<std::vector<double>>(
               {30.0, kAnyError, 0.0},
               has_holes ? std::vector{kAnyError} : std::vector{30.0, kAnyError, 0.0})) {
        SCOPED_TRACE(::testing::Message() << has_holes << " " << max_error << " " << persistence);
        ExtractOptions options{.isovalues = {120.5, 90.5}, .max_error = max_error};
        options.normals = Normals::off;
        options.keep_topology = persistence;
        StoredExtract pieces;
        StoredExtract whole;
        test::extract_stored(lode, options, true, pieces);
        test::extract_stored(lode, options, false, whole);
        if (HasFatalFailure()) return;
        ASSERT_TRUE(pieces.report.topology && whole.report.topology);
        EXPECT_EQ(pieces.report.topology->is_searched, max_error > 0);
        EXPECT_EQ(pieces.report.topology->critical_nodes, whole.report.topology->critical_nodes);
        EXPECT_EQ(pieces.report.topology->nodes, whole.report.topology->nodes);
        EXPECT_EQ(pieces.report.achieved_error, whole.report.achieved_error);
        EXPECT_EQ(pieces.report.topology->weak_regions, whole.report.topology->weak_regions);
        EXPECT_EQ(pieces.report.topology->weak_regions > 0, persistence > 0);
        if (max_error == 0) {  // vertices come in another order
          EXPECT_TRUE(match_surfaces(whole.surface, pieces.surface, 1e-4).is_same());
          continue;
        }
        EXPECT_TRUE(pieces.surface.positions == whole.surface.positions);
        EXPECT_TRUE(pieces.surface.triangles == whole.surface.triangles);
      }
    }
}

/// Each is looked through for its nodes; then all that fit memory are extracted in one pass.
TEST(stored_topology, of_several_isovalues_is_extracted_in_one_pass) {
  const TestPath path("passes.lode");
  const std::string lode = stored(path, rough_waves(long_dims(), ScalarType::uint8));
  ExtractOptions options{.isovalues = {120.5, 90.5, 500, 105.5, 95.5}, .max_error = 30};
  options.normals = Normals::off;
  options.keep_topology = 0;
  StoredExtract whole;
  test::extract_stored(lode, options, false, whole);
  std::array<int, 2> n_passes{};
  for (const std::size_t is_limited : {0U, 1U}) {
    const auto dataset = Dataset::open(lode, options.threads);
    ASSERT_TRUE(dataset);
    if (is_limited != 0) options.memory_limit = dataset->impl().chunk_bytes();
    Progress progress([&](std::string_view phase, double fraction, std::uint64_t) {
      n_passes[is_limited] += phase == "extracting" && fraction == 1 ? 1 : 0;
    });
    Surface surface;
    const auto report = dataset->extract(options, surface, progress);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(dataset->impl().is_in_file());
    EXPECT_TRUE(surface.positions == whole.surface.positions);
    EXPECT_TRUE(surface.triangles == whole.surface.triangles);
    EXPECT_EQ(report->unmet, std::vector<double>{500});
    EXPECT_EQ(report->topology->nodes, whole.report.topology->nodes);
  }
  EXPECT_EQ(n_passes[0], 1);
  EXPECT_GT(n_passes[1], 1) << "where memory is short";
}

TEST(stored_topology, is_that_of_full_resolution) {
  const TestPath path("full.lode");
  const std::string lode = stored(path, rough_waves(long_dims(), ScalarType::uint8));
  StoredExtract full;
  StoredExtract kept;
  StoredExtract coarse;
  ExtractOptions options{.isovalues = {120.5}, .max_error = 0};
  test::extract_stored(lode, options, true, full);
  options.max_error = kAnyError;
  test::extract_stored(lode, options, true, coarse);
  options.keep_topology = 0;
  test::extract_stored(lode, options, true, kept);
  EXPECT_EQ(types_of(kept.surface), types_of(full.surface));
  EXPECT_NE(types_of(coarse.surface), types_of(full.surface));
  EXPECT_LT(kept.surface.triangles.size(), full.surface.triangles.size());
}

/// The whole surface is simplified, none of its pieces dropped.
TEST(stored_topology, is_kept_where_pieces_are_simplified) {
  const TestPath path("simplified.lode");
  const std::string lode = stored(path, rough_waves(long_dims(), ScalarType::uint8));
  StoredExtract full;
  StoredExtract kept;
  test::extract_stored(lode, {.isovalues = {120.5}, .max_error = 0}, true, full);
  ExtractOptions options{.isovalues = {120.5}, .max_error = 12};
  options.simplify = Simplify::edges;
  options.keep_topology = 0;
  test::extract_stored(lode, options, true, kept);
  ASSERT_TRUE(kept.report.simplified && kept.report.topology);
  EXPECT_FALSE(kept.report.topology->is_searched) << "it is of full resolution before";
  EXPECT_EQ(kept.report.simplified->components_dropped, 0U);
  EXPECT_LT(kept.surface.triangles.size(), full.surface.triangles.size() / 2);
  EXPECT_EQ(types_of(kept.surface), types_of(full.surface));
}

TEST(stored_topology, says_so_where_its_nodes_do_not_fit) {
  const TestPath path("large.lode");
  const Volume volume = rough_waves({{300, 40, 32}}, ScalarType::uint8);
  test::save<3>(test::built<3>(volume), path.str());
  const auto reader = store::Reader::open(path.str());
  const auto field = diamond::load_coarse<3>(*reader, *diamond::read_metadata(*reader), {2});
  store::BlockCache blocks(*reader, 1'000'000);
  Progress progress;
  for (const double persistence : {0.0, 2.0}) {
    const auto refused =
        diamond::find_critical_nodes(*field, blocks, {120.5, persistence, {2}, 10'000}, progress);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("keeping the topology"), std::string::npos);
  }
}

TEST(node_set, of_a_part_has_what_lies_in_it) {
  oracles::Random random(4);
  for (const Index3& dims : {Index3{{300, 50, 70}}, Index3{{64, 8, 8}}, Index3{{65, 9, 7}}}) {
    diamond::NodeSet<3> all(diamond::Shape<3>::of(dims));
    for (int i = 0; i < 400; ++i) {
      Index3 p;
      for (std::size_t a = 0; a < 3; ++a)
        p[a] = static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(dims[a])));
      all.set(p);
    }
    Index3 origin;
    Index3 size;
    for (std::size_t a = 0; a < 3; ++a) {
      origin[a] = dims[a] / 3;
      size[a] = dims[a] / 2;
    }
    const auto part = all.part(diamond::Shape<3>::of(size), origin);
    for (std::int32_t z = 0; z < size[2]; ++z)
      for (std::int32_t y = 0; y < size[1]; ++y)
        for (std::int32_t x = 0; x < size[0]; ++x) {
          const Index3 p{{x, y, z}};
          ASSERT_EQ(part.contains(p), all.contains(p + origin)) << x << " " << y << " " << z;
          const std::uint64_t row = part.row(p, 33);
          ASSERT_EQ((row & 1) != 0, part.contains(p));
          if (x + 32 < size[0])
            ASSERT_EQ((row >> 32 & 1) != 0, part.contains(p + Index3{{32, 0, 0}}));
        }
  }
}

}  // namespace
}  // namespace lode
