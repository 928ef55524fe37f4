// Normals of coarse surfaces: what refinement has left out does not shade them.

#include <gtest/gtest.h>

#include "lode/api/dataset.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

/// A ramp along z with noise of the finest level on it, 0.4 up and down by turns.
Volume noisy_ramp() {
  RegularGrid grid;
  grid.dims = {{33, 33, 33}};
  return oracles::volume_of<float>(grid, [](const Index3& p) {
    const bool is_finest = ((p[0] | p[1] | p[2]) & 1) != 0;
    const double noise = (p[0] + p[1] / 2 + p[2] / 2) % 2 == 0 ? 0.4 : -0.4;
    return p[2] + (is_finest ? noise : 0);
  });
}

TEST(normals, of_coarse_surfaces_are_the_coarse_fields) {
  const Volume volume = noisy_ramp();
  Progress progress;
  const auto dataset = Dataset::build(*make_memory_source(volume), {.threads = {2}}, progress);
  ASSERT_TRUE(dataset);
  Surface coarse;
  ASSERT_TRUE(
      dataset->extract({.isovalues = {15.3}, .max_error = 1.0, .threads = {2}}, coarse, progress));
  ASSERT_FALSE(coarse.normals.empty());
  for (const Vec3f& n : coarse.normals) EXPECT_EQ(n, (Vec3f{{0, 0, -1}}));

  Surface fine;
  ASSERT_TRUE(
      dataset->extract({.isovalues = {15.3}, .max_error = 0.0, .threads = {2}}, fine, progress));
  std::size_t n_tilted = 0;
  for (const Vec3f& n : fine.normals) n_tilted += n[2] > -0.99F ? 1 : 0;
  EXPECT_GT(n_tilted, fine.normals.size() / 2);
}

}  // namespace
}  // namespace lode
