// The style of cubes against the number of triangles that marching cubes has, found on its own.

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <vector>

#include "lode/api/dataset.h"
#include "lode/io/volume_reader.h"
#include "tests/models/built_dataset.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

/// Of the loops that marching cubes has in a cell, by its inside corners, the sum of their lengths
/// less two each: on a face with four crossings each inside corner is cut off by itself.
int marching_cubes_triangles(unsigned inside) {
  const auto is_in = [&](unsigned corner) { return (inside >> corner & 1) != 0; };
  // Edges as (lower corner, axis): 3 * corner + axis. Each crossed one has two partners.
  std::array<std::vector<unsigned>, 24> partners;
  const auto edge = [](unsigned a, unsigned b) {
    return 3 * (a & b) + static_cast<unsigned>(std::countr_zero(a ^ b));
  };
  for (unsigned axis = 0; axis < 3; ++axis)
    for (const unsigned side : {0U, 1U}) {
      const unsigned u = 1U << ((axis + 1) % 3);
      const unsigned v = 1U << ((axis + 2) % 3);
      const unsigned base = side << axis;
      const std::array<unsigned, 4> ring{base, base | u, base | u | v, base | v};
      std::vector<unsigned> crossed;
      for (std::size_t i = 0; i < 4; ++i)
        if (is_in(ring[i]) != is_in(ring[(i + 1) % 4]))
          crossed.push_back(edge(ring[i], ring[(i + 1) % 4]));
      const auto join = [&](unsigned a, unsigned b) {
        partners[a].push_back(b);
        partners[b].push_back(a);
      };
      if (crossed.size() == 2) join(crossed[0], crossed[1]);
      if (crossed.size() != 4) continue;
      for (std::size_t i = is_in(ring[0]) ? 0 : 1; i < 4; i += 2)
        join(edge(ring[(i + 3) % 4], ring[i]), edge(ring[i], ring[(i + 1) % 4]));
    }
  int n_edges = 0;
  int n_loops = 0;
  std::array<bool, 24> is_seen{};
  for (unsigned first = 0; first < partners.size(); ++first) {
    if (partners[first].empty() || is_seen[first]) continue;
    ++n_loops;
    std::vector<unsigned> waiting{first};
    while (!waiting.empty()) {
      const unsigned at = waiting.back();
      waiting.pop_back();
      if (is_seen[at]) continue;
      is_seen[at] = true;
      ++n_edges;
      for (const unsigned next : partners[at]) waiting.push_back(next);
    }
  }
  return n_edges - 2 * n_loops;
}

template <typename T>
std::uint64_t marching_cubes_triangles(Volume volume, double isovalue) {
  const auto samples = oracles::typed_samples<T>(volume);
  const Index3& dims = volume.info.grid.dims;
  std::array<int, 256> of_case{};
  for (unsigned inside = 0; inside < 256; ++inside)
    of_case[inside] = marching_cubes_triangles(inside);
  std::uint64_t n = 0;
  Index3 p;
  for (p[2] = 0; p[2] + 1 < dims[2]; ++p[2])
    for (p[1] = 0; p[1] + 1 < dims[1]; ++p[1])
      for (p[0] = 0; p[0] + 1 < dims[0]; ++p[0]) {
        std::size_t inside = 0;
        for (int k = 0; k < 8; ++k) {
          const std::int64_t at =
              ((p[2] + (k >> 2)) * std::int64_t{dims[1]} + p[1] + (k >> 1 & 1)) * dims[0] + p[0] +
              (k & 1);
          if (static_cast<double>(samples[static_cast<std::size_t>(at)]) >= isovalue)
            inside |= std::size_t{1} << k;
        }
        n += static_cast<std::uint64_t>(of_case[inside]);
      }
  return n;
}

std::uint64_t cubes_triangles(const Volume& volume, double isovalue) {
  Progress progress;
  Surface surface;
  const auto report = test::built_dataset(volume).extract({.isovalues = {isovalue},
                                                           .max_error = 0.0,
                                                           .style = SurfaceStyle::cubes,
                                                           .normals = Normals::off,
                                                           .threads = {2}},
                                                          surface, progress);
  EXPECT_TRUE(report) << (report ? "" : report.error().message);
  return surface.triangles.size();
}

template <typename T>
void expect_within_a_percent(const Volume& volume, double isovalue) {
  const auto expected = static_cast<double>(marching_cubes_triangles<T>(volume, isovalue));
  const auto found = static_cast<double>(cubes_triangles(volume, isovalue));
  EXPECT_NEAR(found / expected, 1, 0.01) << found << " and " << expected;
}

TEST(cube_counts, know_marching_cubes) {
  EXPECT_EQ(marching_cubes_triangles(0), 0);
  EXPECT_EQ(marching_cubes_triangles(0b00000001), 1);
  EXPECT_EQ(marching_cubes_triangles(0b00001111), 2);
  EXPECT_EQ(marching_cubes_triangles(0b10000001), 2);
  EXPECT_EQ(marching_cubes_triangles(0b01101001), 4);
  EXPECT_EQ(marching_cubes_triangles(0b11111110), 1);
}

TEST(cube_counts, are_within_a_percent_of_marching_cubes) {
  const auto source = io::open_volume(LODE_SAMPLES_DIR "/tooth.nrrd", {});
  ASSERT_TRUE(source) << source.error().message;
  const auto tooth = read_all(**source);
  ASSERT_TRUE(tooth) << tooth.error().message;
  expect_within_a_percent<std::uint16_t>(*tooth, 600);
  expect_within_a_percent<std::uint16_t>(*tooth, 1000);
  expect_within_a_percent<float>(oracles::sample(oracles::Field::gaussians40, 65), 1);
}

}  // namespace
}  // namespace lode
