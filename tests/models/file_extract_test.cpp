// Surfaces from a file, chunk by chunk, are those from memory.
#include "lode/models/diamond/file_extract.h"

#include <functional>
#include <map>
#include <set>

#include "lode/mappers/surface_edits.h"
#include "tests/models/stored_fixtures.h"
#include "tests/oracles/trials.h"

namespace lode::diamond {
namespace {

using store::TestPath;

/// Smooth with some noise: cuts have simplices of all sizes.
Volume hilly(const Index3& dims, ScalarType type) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{1, 0.5, 2}};
  Volume volume = oracles::empty_volume(grid, type);
  oracles::Random random(5);
  visit_scalar_type(type, [&]<typename T>() {
    auto samples = oracles::typed_samples<T>(volume);
    std::size_t at = 0;
    for (int z = 0; z < dims[2]; ++z)
      for (int y = 0; y < dims[1]; ++y)
        for (int x = 0; x < dims[0]; ++x)
          samples[at++] = static_cast<T>(110 + 60 * std::sin(x * 0.04) * std::cos(y * 0.05) +
                                         40 * std::sin(z * 0.03 + x * 0.01) +
                                         (x > dims[0] / 2 ? double(random.below(8)) : 0.0));
  });
  return volume;
}

/// Of one isovalue: the query's.
template <int D>
Result<IsosurfaceReport> extracted_from_file(const CoarseField<D>& field, store::BlockCache& blocks,
                                             const IsosurfaceQuery& query, Surface& surface) {
  Progress progress;
  SurfaceCollector collector(surface);
  return extract_from_file<D>(
      field, blocks, IsovalueList::of({{query.isovalue}}), query,
      [&](std::size_t) { return &collector; }, progress);
}

template <int D>
void expect_same_surface(const Volume& volume, double tolerance, std::uint64_t cache_bytes,
                         double isovalue = 120.3) {
  const TestPath path("volume.lode");
  const Model<D> model = test::built<D>(volume);
  test::save<D>(model, path.str());
  const auto reader = store::Reader::open(path.str());
  ASSERT_TRUE(reader);
  const auto metadata = read_metadata(*reader);
  ASSERT_TRUE(metadata);
  const auto field = load_coarse<D>(*reader, *metadata, {2});
  ASSERT_TRUE(field) << field.error().message;
  store::BlockCache blocks(*reader, cache_bytes);
  const IsosurfaceQuery query{
      .isovalue = isovalue, .tolerance = tolerance, .threads = {2}, .with_normals = D == 3};
  Surface expected;
  Surface got;
  Progress progress;
  const auto wanted = extract_isosurface<D>(model, query, expected, progress);
  const auto report = extracted_from_file<D>(*field, blocks, query, got);
  ASSERT_TRUE(wanted && report) << (report ? "" : report.error().message);
  ASSERT_FALSE(got.is_empty());
  EXPECT_EQ(report->achieved_error, wanted->achieved_error);
  EXPECT_EQ(report->nodes_visited, wanted->nodes_visited);
  EXPECT_EQ(report->coordinate_slack, wanted->coordinate_slack);
  EXPECT_TRUE(got.positions == expected.positions);
  EXPECT_TRUE(got.triangles == expected.triangles);
  EXPECT_TRUE(got.lines == expected.lines);
  ASSERT_EQ(got.normals.size(), expected.normals.size());
  std::size_t n_different = 0;
  for (std::size_t i = 0; i < got.normals.size(); ++i)
    n_different += got.normals[i] == expected.normals[i] ? 0 : 1;
  EXPECT_EQ(n_different, 0U);
}

struct ExtractCase {
  Index3 dims;
  ScalarType type = ScalarType::uint8;
  double tolerance = 0;

  friend void PrintTo(const ExtractCase& c, std::ostream* out) {
    *out << fmt::format("{} x {} x {} {} within {}", c.dims[0], c.dims[1], c.dims[2],
                        name_of(c.type), c.tolerance);
  }
};

class file_extract : public ::testing::TestWithParam<ExtractCase> {};

TEST_P(file_extract, gives_the_surface_of_the_model_in_memory) {
  const ExtractCase& c = GetParam();
  const Volume volume = hilly(c.dims, c.type);
  for (const std::uint64_t cache_bytes : {std::uint64_t{0}, std::uint64_t{64} << 20}) {
    if (std::min({c.dims[0], c.dims[1], c.dims[2]}) == 1)
      expect_same_surface<2>(volume, c.tolerance, cache_bytes);
    else
      expect_same_surface<3>(volume, c.tolerance, cache_bytes);
  }
}

INSTANTIATE_TEST_SUITE_P(
    cases, file_extract,
    ::testing::Values(ExtractCase{{{40, 45, 50}}, ScalarType::uint8, 2.5},
                      ExtractCase{oracles::trials<Index3>({{257, 65, 129}}, {{257, 33, 129}}),
                                  ScalarType::uint8, 5},
                      ExtractCase{oracles::trials<Index3>({{300, 280, 40}}, {{300, 280, 14}}),
                                  ScalarType::uint8, 1.5},
                      ExtractCase{oracles::trials<Index3>({{290, 50, 270}}, {{290, 20, 270}}),
                                  ScalarType::float32, 12},
                      ExtractCase{{{60, 530, 40}}, ScalarType::int16, 0.25},
                      ExtractCase{{{7, 9, 260}}, ScalarType::float64, 1},
                      ExtractCase{{{2100, 500, 1}}, ScalarType::uint8, 3}));

/// A plane through the middle, nearly: most bricks have no fine node, and where the data ends
/// samples beyond it are those of finer levels.
Volume ramp(const Index3& dims, const Vec3d& slope) {
  RegularGrid grid;
  grid.dims = dims;
  return oracles::volume_of<std::uint8_t>(grid, [&](const Index3& p) {
    double value = 124.5;
    for (std::size_t i = 0; i < 3; ++i) value += slope[i] * (p[i] - dims[i] / 2);
    return std::clamp(std::round(value), 0.0, 255.0);
  });
}

TEST(file_extract_ramps, have_the_samples_beyond_the_data_that_the_model_has) {
  expect_same_surface<3>(ramp({{560, 40, 32}}, {{0.18, 0.1, 0.4}}), 1.275, 0, 124.5);
  expect_same_surface<3>(ramp({{560, 40, 32}}, {{-0.16, -0.3, 0.2}}), 1.275, 0, 124.5);
  expect_same_surface<3>(ramp({{200, 40, 30}}, {{0.45, 0.8, 0.1}}), 0.6, 0, 124.5);
  oracles::Random random(31);
  for (int trial = 0; trial < oracles::trials(30, 8); ++trial) {
    const Vec3d slope{{random.uniform(-0.6, 0.6), random.uniform(-1, 1), random.uniform(-1, 1)}};
    expect_same_surface<3>(ramp({{200, 40, 30}}, slope), 0.6, 0, 124.5);
    expect_same_surface<2>(ramp({{300, 270, 1}}, slope), 0.6, 0, 124.5);
  }
}

/// Which samples are holes.
using IsHole = std::function<bool(const Index3&)>;

Volume with_holes(Volume volume, const IsHole& is_hole) {
  const Index3& dims = volume.info.grid.dims;
  const bool is_integer = !is_floating(volume.info.type);
  if (is_integer) volume.info.nodata = 3;
  visit_scalar_type(volume.info.type, [&]<typename T>() {
    auto samples = oracles::typed_samples<T>(volume);
    std::size_t at = 0;
    for (int z = 0; z < dims[2]; ++z)
      for (int y = 0; y < dims[1]; ++y)
        for (int x = 0; x < dims[0]; ++x, ++at)
          if (is_hole(Index3{{x, y, z}}))
            samples[at] = is_integer ? T(3) : std::numeric_limits<T>::quiet_NaN();
  });
  return volume;
}

struct HolesCase {
  std::string name;
  Index3 dims;
  ScalarType type = ScalarType::uint8;
  double tolerance = 0;
  IsHole is_hole;

  friend void PrintTo(const HolesCase& c, std::ostream* out) { *out << c.name; }
};

class file_extract_holes : public ::testing::TestWithParam<HolesCase> {};

TEST_P(file_extract_holes, give_the_surface_of_the_model_in_memory) {
  const HolesCase& c = GetParam();
  const Volume volume = with_holes(hilly(c.dims, c.type), c.is_hole);
  if (std::min({c.dims[0], c.dims[1], c.dims[2]}) == 1)
    expect_same_surface<2>(volume, c.tolerance, 0);
  else
    expect_same_surface<3>(volume, c.tolerance, std::uint64_t{64} << 20);
}

/// One in n, at random.
bool is_random(const Index3& p, std::uint32_t n) {
  const auto scaled = [&](std::size_t axis, std::uint32_t factor) {
    return static_cast<std::uint32_t>(p[axis]) * factor;
  };
  std::uint32_t h = scaled(0, 73856093) ^ scaled(1, 19349663) ^ scaled(2, 83492791);
  h ^= h >> 13;
  h *= 0x5bd1e995U;
  return (h >> 8) % n == 0;
}
bool is_rare(const Index3& p) { return is_random(p, 3000); }
bool is_frequent(const Index3& p) { return is_random(p, 30); }
/// All that no coarser level has, in half of the field: coarse samples look as if nothing were
/// removed.
bool is_fine_grid(const Index3& p) {
  return p[0] < 150 && (p[0] & 1) != 0 && (p[1] & 1) != 0 && (p[2] & 1) != 0;
}
bool is_outside(const Index3& p) {
  const int x = p[0] - 140;
  const int y = p[1] - 130;
  return x * x + y * y > 120 * 120;
}
bool is_in_slab(const Index3& p) { return p[2] >= 255 && p[2] <= 257 && p[0] != 20; }

template <int D>
void expect_places(const Index<D>& lower, const Index<D>& upper, bool has_coarser_points) {
  const Region<D> r{1, {}, lower, upper, has_coarser_points};
  std::size_t place = 0;
  for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
    for (std::int32_t i = 0; i < n; ++i, q[0] += stride) EXPECT_EQ(place_in<D>(r, q), place++);
  });
  EXPECT_EQ(place, count_points<D>(r));
}

TEST(file_extract_places, of_points_are_those_in_the_order_of_a_block) {
  for (const bool has_coarser_points : {false, true}) {
    for (const std::int32_t x : {0, 3, 64})
      expect_places<3>({{x, 64, 5}}, {{x + 6, 69, 12}}, has_coarser_points);
    expect_places<3>({{0, 0, 0}}, {{1, 1, 2}}, has_coarser_points);
    expect_places<2>({{512, 7}}, {{521, 12}}, has_coarser_points);
  }
}

TEST(file_extract_twins, are_where_holes_would_pinch_the_surface) {
  // Slabs of two chunks: edges on their common border have twins too.
  const Volume volume = with_holes(hilly({{280, 60, 50}}, ScalarType::float32), is_frequent);
  const Model<3> model = test::built<3>(volume);
  for (const double tolerance : {0.0, 0.5, 20.0}) {
    Surface surface;
    Progress progress;
    ASSERT_TRUE(extract_isosurface<3>(model, {.isovalue = 120.3, .tolerance = tolerance}, surface,
                                      progress));
    std::set<std::array<float, 3>> places;
    for (const Vec3f& p : surface.positions) places.insert(p.v);
    const std::size_t n_vertices = surface.positions.size();
    EXPECT_GT(n_vertices, places.size() + 100) << tolerance;
    split_pinched_vertices(surface);
    EXPECT_EQ(surface.positions.size(), n_vertices) << tolerance;
    // Nor are there more than that takes: welded again, as many must be split.
    std::map<std::array<float, 3>, std::uint32_t> first;
    std::vector<std::uint32_t> welded(n_vertices);
    Surface again;
    for (std::uint32_t v = 0; v < n_vertices; ++v) {
      const auto [at, is_new] = first.emplace(surface.positions[v].v, again.positions.size());
      if (is_new) again.positions.push_back(surface.positions[v]);
      welded[v] = at->second;
    }
    for (auto triangle : surface.triangles) {
      for (std::uint32_t& v : triangle) v = welded[v];
      again.triangles.push_back(triangle);
    }
    split_pinched_vertices(again);
    EXPECT_EQ(again.positions.size(), n_vertices) << tolerance;
  }
}

INSTANTIATE_TEST_SUITE_P(
    cases, file_extract_holes,
    ::testing::Values(
        HolesCase{"random", oracles::trials<Index3>({{290, 70, 60}}, {{290, 40, 34}}),
                  ScalarType::float32, 4, is_rare},
        HolesCase{"random_uint8", {{60, 270, 65}}, ScalarType::uint8, 2, is_rare},
        HolesCase{"random_full", {{40, 45, 50}}, ScalarType::float32, 0.01, is_rare},
        HolesCase{"fine_grid", {{300, 129, 70}}, ScalarType::uint8, 30, is_fine_grid},
        HolesCase{"fine_grid_coarse", oracles::trials<Index3>({{300, 280, 129}}, {{300, 280, 40}}),
                  ScalarType::float32, 60, is_fine_grid},
        HolesCase{"frequent", oracles::trials<Index3>({{280, 60, 50}}, {{280, 30, 20}}),
                  ScalarType::float32, 3, is_frequent},
        HolesCase{"outside", oracles::trials<Index3>({{290, 270, 50}}, {{290, 270, 20}}),
                  ScalarType::int16, 8, is_outside},
        HolesCase{"slab_at_a_chunk", {{60, 70, 300}}, ScalarType::uint8, 3, is_in_slab},
        HolesCase{"flat", {{2100, 400, 1}}, ScalarType::float32, 3, is_rare}),
    [](const auto& test) { return test.param.name; });

TEST(file_extract_blocks, that_the_surface_does_not_need_are_not_read) {
  // A ball in a corner: most chunks have no surface.
  const TestPath path("ball.lode");
  RegularGrid grid;
  grid.dims = {{300, 300, 300}};
  const Volume volume = oracles::volume_of<std::uint8_t>(grid, [](const Index3& p) {
    return 250.0 / (1.0 + 0.002 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]));
  });
  test::save<3>(test::built<3>(volume), path.str());
  const auto reader = store::Reader::open(path.str());
  ASSERT_TRUE(reader);
  const auto metadata = read_metadata(*reader);
  const auto field = load_coarse<3>(*reader, *metadata, {2});
  ASSERT_TRUE(field);
  store::BlockCache blocks(*reader, 0);
  Surface surface;
  ASSERT_TRUE(extracted_from_file<3>(*field, blocks,
                                     {.isovalue = 100, .tolerance = 1, .threads = {2}}, surface));
  EXPECT_FALSE(surface.is_empty());
  EXPECT_LT(blocks.n_blocks_read(), reader->blocks().size() / 4);
}

TEST(file_extract_blocks, with_holes_that_the_metadata_deny_are_refused) {
  Volume volume = hilly({{60, 60, 60}}, ScalarType::float32);
  oracles::typed_samples<float>(volume)[100003] = std::numeric_limits<float>::quiet_NaN();
  const TestPath path("lie.lode");
  Model<3> model = test::built<3>(volume);
  model.stats.n_holes = model.stats.n_removed_cells = 0;
  test::save<3>(model, path.str());
  const auto reader = store::Reader::open(path.str());
  ASSERT_TRUE(reader);
  const auto metadata = read_metadata(*reader);
  const auto field = load_coarse<3>(*reader, *metadata, {2});
  ASSERT_TRUE(field);
  store::BlockCache blocks(*reader, 0);
  Surface surface;
  const auto done = extracted_from_file<3>(
      *field, blocks, {.isovalue = 120.3, .tolerance = 0.01, .threads = {2}}, surface);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("expected no holes"), std::string::npos)
      << done.error().message;
}

TEST(file_extract_blocks, whose_errors_are_not_those_of_the_metadata_are_refused) {
  const TestPath path("lie.lode");
  Model<3> model = test::built<3>(hilly({{60, 60, 60}}, ScalarType::uint8));
  test::save<3>(model, path.str());
  const auto reader = store::Reader::open(path.str());
  ASSERT_TRUE(reader);
  auto metadata = read_metadata(*reader);
  ASSERT_TRUE(metadata);
  metadata->summary.base_error += 1;
  EXPECT_FALSE(load_coarse<3>(*reader, *metadata, {2}));
  metadata->summary.base_error -= 1;
  metadata->summary.max_errors[kKeptLevel] += 1;
  EXPECT_FALSE(load_coarse<3>(*reader, *metadata, {2}));
}

}  // namespace
}  // namespace lode::diamond
