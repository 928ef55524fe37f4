// Normals at tolerance 0, found in rows, must be those of central differences at the edges' ends.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lode/api/dataset.h"
#include "tests/models/all_targets.h"
#include "tests/models/built_dataset.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

const Vec3d kSpacing{{0.5, 1, 0.75}};

/// Noise in blocks, and what is far from the isovalue between them.
class Samples {
 public:
  Samples(const Index3& dims, std::uint64_t seed) : dims_(dims) {
    oracles::Random random(seed);
    values_.resize(static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) *
                   static_cast<std::size_t>(dims[2]));
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const auto x = static_cast<std::int32_t>(i % static_cast<std::size_t>(dims[0]));
      values_[i] = std::floor(x / 5 % 3 == 1 ? 200 : random.uniform(0, 200));
    }
  }
  [[nodiscard]] double at(const Index3& p) const {
    const auto size = [](std::int32_t x) { return static_cast<std::size_t>(x); };
    return values_[(size(p[2]) * size(dims_[1]) + size(p[1])) * size(dims_[0]) + size(p[0])];
  }
  /// In the world, by differences of what is there on both sides, or on one.
  [[nodiscard]] Vec3d gradient(const Index3& p) const {
    Vec3d gradient;
    for (std::size_t i = 0; i < 3; ++i) {
      Index3 low = p;
      Index3 high = p;
      low[i] = std::max(p[i] - 1, 0);
      high[i] = std::min(p[i] + 1, dims_[i] - 1);
      gradient[i] = (at(high) - at(low)) / (kSpacing[i] * (high[i] - low[i]));
    }
    return gradient;
  }

 private:
  Index3 dims_;
  std::vector<double> values_;
};

/// Of a vertex: an edge's coordinates are even at its first end, odd at its second one, along the
/// axes that it does not stay in.
Vec3d gradient_at(const Samples& samples, const Surface& surface, std::uint32_t v) {
  const Vec3d p = surface.world_position(v);
  Index3 first;
  Index3 second;
  double t = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = p[i] / kSpacing[i];
    const auto nearest = static_cast<std::int32_t>(std::lround(x));
    first[i] = second[i] = nearest;
    if (std::abs(x - nearest) < 1e-4) continue;
    const auto low = static_cast<std::int32_t>(std::floor(x));
    first[i] = low % 2 == 0 ? low : low + 1;
    second[i] = low % 2 == 0 ? low + 1 : low;
    t = std::abs(x - first[i]);
  }
  return samples.gradient(first) * (1 - t) + samples.gradient(second) * t;
}

void expect_normals(const Surface& surface, const Samples& samples) {
  ASSERT_FALSE(surface.is_empty());
  ASSERT_EQ(surface.normals.size(), surface.positions.size());
  // Floats have the edge parameter to 1e-4 of 0 to 200 along an axis of some hundred samples, so
  // that gradients of at least 8 have the directions of their normals to less than a hundredth.
  std::size_t n_seen = 0;
  for (std::uint32_t v = 0; v < surface.positions.size(); ++v) {
    const Vec3d gradient = gradient_at(samples, surface, v);
    if (length(gradient) < 8) continue;
    ++n_seen;
    const Vec3d expected = normalized(gradient) * -1.0;
    for (std::size_t i = 0; i < 3; ++i)
      ASSERT_NEAR(surface.normals[v][i], expected[i], 0.02) << "vertex " << v;
  }
  EXPECT_GT(2 * n_seen, surface.positions.size());
}

template <typename T>
void expect_normals_of(const Index3& dims) {
  const Samples samples(dims, 17);
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = kSpacing;
  const Dataset dataset = test::built_dataset(
      oracles::volume_of<T>(grid, [&](const Index3& p) { return samples.at(p); }));
  Progress progress;
  for (const SurfaceStyle style : {SurfaceStyle::tetra, SurfaceStyle::cubes})
    test::for_each_target([&] {
      Surface surface;
      ASSERT_TRUE(
          dataset.extract({.isovalues = {100.5}, .max_error = 0, .style = style, .threads = {2}},
                          surface, progress));
      expect_normals(surface, samples);
    });
}

TEST(full_resolution_normals, are_of_central_differences_and_one_sided_at_the_ends) {
  for (const Index3& dims : oracles::trials<std::vector<Index3>>(
           {{{2, 2, 2}},
            {{3, 2, 5}},
            {{16, 4, 3}},
            {{17, 3, 4}},
            {{33, 7, 4}},
            {{34, 33, 5}},
            {{65, 5, 34}},
            {{49, 66, 35}},
            {{5, 34, 33}},
            {{300, 70, 5}}},
           {{{3, 2, 5}}, {{17, 3, 4}}, {{32, 4, 3}}, {{33, 7, 4}}, {{34, 33, 5}}, {{49, 5, 34}}})) {
    SCOPED_TRACE(testing::Message() << dims[0] << " " << dims[1] << " " << dims[2]);
    expect_normals_of<std::uint8_t>(dims);
    expect_normals_of<std::uint16_t>(dims);
    expect_normals_of<std::int16_t>(dims);
    expect_normals_of<float>(dims);
    expect_normals_of<double>(dims);
  }
}

}  // namespace
}  // namespace lode
