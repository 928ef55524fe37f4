// Tolerance 0: the flat passes over rows of cells must give the surface in all finest simplices.

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "lode/api/dataset.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/cell_rows.h"
#include "tests/models/all_targets.h"
#include "tests/models/built_dataset.h"
#include "tests/models/finest_level_set.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using test::finest_level_set;

Surface full_resolution(const Volume& volume, double isovalue) {
  Progress progress;
  const auto source = make_memory_source(volume);
  auto dataset = Dataset::build(*source, {.threads = {1}}, progress);
  EXPECT_TRUE(dataset) << (dataset ? "" : dataset.error().message);
  Surface surface;
  EXPECT_TRUE(dataset->extract(
      {.isovalues = {isovalue}, .max_error = 0.0, .normals = Normals::off, .threads = {1}}, surface,
      progress));
  return surface;
}

/// Twice the area vector, and six times the signed volume under the surface.
std::array<double, 4> moments(const Surface& surface) {
  std::array<double, 4> sum{};
  for (const auto& t : surface.triangles) {
    const Vec3d a = surface.world_position(t[0]);
    const Vec3d b = surface.world_position(t[1]);
    const Vec3d c = surface.world_position(t[2]);
    const Vec3d n = cross(b - a, c - a);
    for (std::size_t i = 0; i < 3; ++i) sum[i] += n[i];
    sum[3] += dot(a, cross(b, c));
  }
  return sum;
}

void expect_same_surface(const Surface& ours, const Surface& oracle, double slack) {
  const auto a = check_topology(ours, {});
  const auto b = check_topology(oracle, {});
  EXPECT_TRUE(a.is_clean_manifold());
  EXPECT_EQ(a.n_simplices, b.n_simplices);
  EXPECT_EQ(a.n_used_vertices, b.n_used_vertices);
  EXPECT_EQ(a.n_edges, b.n_edges);
  EXPECT_EQ(a.n_boundary_edges, b.n_boundary_edges);
  EXPECT_EQ(a.euler_number, b.euler_number);
  EXPECT_EQ(a.components.size(), b.components.size());
  const auto m = moments(ours);
  const auto n = moments(oracle);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(m[i], n[i], slack) << "moment " << i;
}

/// Blocks of 48 x 48 x 12 samples that are low, high, or noise: boxes of one side, and rows of
/// boxes that no surface meets, beside others.
Volume volume_of_blocks(const Index3& dims, std::uint32_t seed) {
  RegularGrid grid;
  grid.dims = dims;
  Volume volume = test::random_volume(grid, seed);
  auto* const samples = reinterpret_cast<float*>(volume.samples.data());
  EXPECT_EQ(volume.info.type, ScalarType::float32);
  std::size_t at = 0;
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (std::int32_t x = 0; x < dims[0]; ++x, ++at) {
        const std::int32_t block = (x / 48 * 5 + y / 48 * 3 + z / 12 * 7) / 4 % 3;
        if (block < 2) samples[at] = block == 0 ? -3.0F : 3.0F;
      }
  return volume;
}

void expect_same_numbers(const Surface& a, const Surface& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.isovalues, b.isovalues);
}

/// Into the memory of any other surface, with any number of threads, it is the same.
TEST(full_resolution_memory, says_nothing_about_the_surface) {
  for (const Index3 dims : {Index3{{37, 21, 70}}, Index3{{97, 98, 34}}, Index3{{65, 66, 9}},
                            Index3{{130, 40, 10}}, Index3{{66, 100, 97}}}) {
    const Dataset dataset = test::built_dataset(volume_of_blocks(dims, 5));
    Progress progress;
    for (const auto style : {SurfaceStyle::tetra, SurfaceStyle::cubes}) {
      ExtractOptions options{.isovalues = {0.25},
                             .max_error = 0,
                             .style = style,
                             .normals = dims[2] == 70 ? Normals::on : Normals::off,
                             .threads = {1}};
      Surface alone;
      ASSERT_TRUE(dataset.extract(options, alone, progress));
      ASSERT_TRUE(alone.isovalues.empty());
      Surface reused;
      for (const double other : {0.9, 0.25, -0.5, 5.0})
        for (const int threads : {1, 2, 3, 6}) {
          options.threads = {threads};
          options.isovalues = {other};
          ASSERT_TRUE(dataset.extract(options, reused, progress));
          if (threads == 3) reused.isovalues.resize(reused.isovalues.size() / 2);
          if (threads == 6) reused.positions.resize(reused.positions.size() / 2);
          options.isovalues = {0.25};
          ASSERT_TRUE(dataset.extract(options, reused, progress));
          expect_same_numbers(reused, alone);
        }
    }
  }
}

TEST(full_resolution_memory, appends_the_same_for_any_number_of_threads) {
  const Dataset dataset = test::built_dataset(volume_of_blocks({{66, 50, 97}}, 6));
  Progress progress;
  ExtractOptions options{.isovalues = {0.25, -0.5, 0.5}, .max_error = 0, .threads = {1}};
  Surface alone;
  ASSERT_TRUE(dataset.extract(options, alone, progress));
  for (const int threads : {2, 5}) {
    options.threads = {threads};
    Surface surface;
    ASSERT_TRUE(dataset.extract(options, surface, progress));
    expect_same_numbers(surface, alone);
  }
}

TEST(full_resolution_memory, is_empty_after_an_error) {
  const Dataset dataset = test::built_dataset(volume_of_blocks({{66, 50, 97}}, 6));
  Progress progress;
  ExtractOptions options{.isovalues = {0.25}, .max_error = 0, .threads = {2}};
  Surface surface;
  ASSERT_TRUE(dataset.extract(options, surface, progress));
  options.isovalues = {0.3};
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(dataset.extract(options, surface, cancelled));
  EXPECT_TRUE(surface.is_empty());
  EXPECT_TRUE(surface.positions.empty());
}

/// As signs change from each sample to the next all cells have twelve triangles, the most there
/// are.
TEST(full_resolution_memory, counts_more_than_four_billion_triangles_a_slice) {
  constexpr std::int32_t kSide = 19000;
  diamond::SignField field;
  field.resize({{kSide, kSide, 2}});
  field.box_dims = {{(kSide + 30) / 32, (kSide + 30) / 32, 1}};
  for (std::int32_t z = 0; z < 2; ++z)
    for (std::size_t word = 0; word < field.stride; ++word) {
      std::uint32_t* rows = &field.words[field.offset(word, 0, z)];
      for (std::size_t y = 0; y < field.row_stride; ++y)
        rows[y] = (y + diamond::as_size(z)) % 2 == 0 ? 0x55555555U : 0xAAAAAAAAU;
    }
  std::vector<std::uint32_t> all(field.n_words());
  std::iota(all.begin(), all.end(), 0U);
  field.met.assign(diamond::as_size(field.box_dims[1]), all);
  std::vector<diamond::RowStart> starts(kSide);
  const auto n = diamond::count_slice(field, 0, SurfaceStyle::tetra, starts.data());
  EXPECT_EQ(n.triangles, 12 * std::uint64_t{kSide - 1} * (kSide - 1));
}

class full_resolution_shapes : public testing::TestWithParam<Index3> {};

TEST_P(full_resolution_shapes, has_the_oracles_surface) {
  RegularGrid grid;
  grid.dims = GetParam();
  grid.spacing = {{0.5, 1.0, 0.75}};
  grid.origin = {{-3, 2, 1}};
  for (const bool is_mirrored : {false, true}) {
    if (is_mirrored) grid.direction = {{Vec3d{{0, 1, 0}}, Vec3d{{1, 0, 0}}, Vec3d{{0, 0, 1}}}};
    const Volume volume = test::random_volume(grid, 5);
    // The oracle keeps 1e-3 of an edge from its ends, Lode only what float32 needs.
    const double slack = 1e-4 * static_cast<double>(grid.n_samples());
    expect_same_surface(full_resolution(volume, 0.25), finest_level_set(volume, 0.25), slack);
  }
}

INSTANTIATE_TEST_SUITE_P(dims, full_resolution_shapes,
                         testing::Values(Index3{{2, 2, 2}}, Index3{{3, 3, 3}}, Index3{{2, 30, 2}},
                                         Index3{{32, 5, 6}}, Index3{{33, 7, 4}},
                                         Index3{{34, 33, 5}}, Index3{{5, 34, 33}},
                                         Index3{{65, 4, 34}}, Index3{{4, 3, 66}}));

TEST(full_resolution, is_a_manifold_with_the_tetrahedra_s_euler_number_on_random_volumes) {
  std::mt19937 random(2026);
  for (int i = 0; i < 1500; ++i) {
    RegularGrid grid;
    for (std::size_t axis = 0; axis < 3; ++axis)
      grid.dims[axis] = 2 + static_cast<std::int32_t>(random() % 4);
    std::vector<float> samples(static_cast<std::size_t>(grid.n_samples()));
    // Few values, so that many samples equal the isovalue and every ambiguous case comes up.
    for (float& s : samples) s = static_cast<float>(random() % 4);
    const Volume volume = make_volume<float>(grid, samples);
    const auto ours = check_topology(full_resolution(volume, 2), {});
    const auto oracle = check_topology(finest_level_set(volume, 2), {});
    ASSERT_TRUE(ours.is_clean_manifold()) << "volume " << i;
    ASSERT_EQ(ours.euler_number, oracle.euler_number) << "volume " << i;
    ASSERT_EQ(ours.n_simplices, oracle.n_simplices) << "volume " << i;
  }
}

/// Where words, rows that are looked at together, and slices end.
TEST(full_resolution, surrounds_a_sample_anywhere) {
  RegularGrid grid;
  grid.dims = {{34, 9, 10}};
  for (const std::int32_t z : {0, 1, 7, 8, 9})
    for (const std::int32_t y : {0, 1, 6, 7, 8})
      for (const std::int32_t x : {0, 1, 30, 31, 32, 33}) {
        const Volume volume = oracles::volume_of<float>(grid, [&](const Index3& p) {
          return p == Index3{{x, y, z}} ? 1.0 : 0.0;
        });
        SCOPED_TRACE(testing::Message() << x << " " << y << " " << z);
        expect_same_surface(full_resolution(volume, 0.25), finest_level_set(volume, 0.25), 0.1);
      }
}

TEST(full_resolution, holds_every_sample_type_and_extreme_isovalue) {
  RegularGrid grid;
  grid.dims = {{36, 5, 4}};
  std::mt19937 random(3);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(grid.n_samples()));
  for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random() % 256);
  std::vector<float> floats(bytes.begin(), bytes.end());
  const Volume as_bytes = make_volume<std::uint8_t>(grid, bytes);
  const Volume as_floats = make_volume<float>(grid, floats);
  const auto converted = [&]<typename T>(T) {
    return make_volume<T>(grid, std::vector<T>(bytes.begin(), bytes.end()));
  };
  for (const double isovalue : {0.0, 0.5, 127.5, 128.0, 255.0, 255.5}) {
    const Surface expected = full_resolution(as_floats, isovalue);
    for (const Volume& volume : {as_bytes, converted(std::uint16_t{}), converted(std::int16_t{}),
                                 converted(double{}), converted(std::int32_t{})}) {
      const Surface surface = full_resolution(volume, isovalue);
      EXPECT_EQ(surface.positions, expected.positions);
      EXPECT_EQ(surface.triangles, expected.triangles);
    }
  }
}

Surface surface_of(const Dataset& dataset, Normals normals) {
  Surface surface;
  Progress progress;
  EXPECT_TRUE(dataset.extract(
      {.isovalues = {90.5, 120}, .max_error = 0.0, .normals = normals, .threads = {2}}, surface,
      progress));
  return surface;
}

/// Noise along some rows, waves elsewhere: full words of crossed edges, and single ones.
template <typename T>
Volume mixed_volume(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{0.5, 1.25, 0.75}};
  grid.origin = {{1000, 2, -7}};
  oracles::Random random(11);
  return oracles::volume_of<T>(grid, [&](const Index3& p) {
    if (p[1] % 5 == 0) return random.uniform(0, 200);
    return 100 + 60 * std::sin(0.2 * p[0]) * std::cos(0.3 * p[1] + 0.1 * p[2]);
  });
}

template <typename T>
void expect_the_same_bytes_with_all_targets(const Index3& dims) {
  Progress progress;
  const Volume volume = mixed_volume<T>(dims);
  const Dataset dataset =
      Dataset::build(*make_memory_source(volume), {.threads = {1}}, progress).value();
  const Surface expected = surface_of(dataset, Normals::on);
  EXPECT_FALSE(expected.is_empty());
  EXPECT_TRUE(check_topology(expected, {}).is_clean_manifold());
  test::for_each_target([&] {
    for (const Normals normals : {Normals::on, Normals::off}) {
      const Surface surface = surface_of(dataset, normals);
      EXPECT_TRUE(surface.positions == expected.positions);
      EXPECT_TRUE(surface.triangles == expected.triangles);
      if (normals == Normals::on) EXPECT_TRUE(surface.normals == expected.normals);
    }
  });
}

TEST(full_resolution, sees_single_samples_wherever_vectors_end) {
  RegularGrid grid;
  grid.dims = {{1100, 4, 4}};
  for (const std::int32_t shift : {-1, 0, 1}) {
    // One inside sample a row, at the end of a word or next to it.
    const Volume volume = oracles::volume_of<float>(grid, [&](const Index3& p) {
      const std::int32_t x = 32 * (1 + 9 * (p[1] * 4 + p[2]) % 33) + shift;
      return (p[1] + p[2]) % 2 == 0 && p[0] == x ? 1.0 : 0.0;
    });
    const Surface oracle = finest_level_set(volume, 0.25);
    test::for_each_target(
        [&] { expect_same_surface(full_resolution(volume, 0.25), oracle, 1e-4 * 17600); });
  }
}

TEST(full_resolution, has_the_same_bytes_with_every_kind_of_vector) {
  for (const Index3& dims : oracles::trials<std::vector<Index3>>(
           {{{33, 40, 20}}, {{70, 41, 9}}, {{257, 34, 5}}, {{600, 7, 6}}},
           {{{33, 20, 7}}, {{70, 15, 5}}, {{257, 9, 4}}, {{600, 4, 3}}})) {
    SCOPED_TRACE(dims[0]);
    expect_the_same_bytes_with_all_targets<std::uint8_t>(dims);
    expect_the_same_bytes_with_all_targets<std::uint16_t>(dims);
    expect_the_same_bytes_with_all_targets<std::int16_t>(dims);
    expect_the_same_bytes_with_all_targets<float>(dims);
    expect_the_same_bytes_with_all_targets<double>(dims);
  }
}

}  // namespace
}  // namespace lode
