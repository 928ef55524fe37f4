// Which boxes of samples full resolution reads, and what it takes for known of the others.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "lode/models/diamond/build.h"
#include "lode/models/diamond/sign_field.h"
#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using diamond::as_size;
using diamond::SampleRange;

template <typename T>
Volume noise_of(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  oracles::Random random(23);
  return oracles::volume_of<T>(grid, [&](const Index3&) { return random.uniform(0, 250); });
}

diamond::Model<3> model_of(const Volume& volume) {
  Progress progress;
  auto model = diamond::build<3>(*make_memory_source(volume), {.threads = {2}}, progress);
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return std::move(model).value();
}

/// Of the samples of a brick and a layer, with those behind them that its edges end at.
SampleRange range_of(const diamond::Model<3>& model, const Index3& brick, std::int32_t layer) {
  SampleRange range{std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};
  Index3 lower = brick * diamond::kBrickEdge<3>;
  Index3 size = diamond::all_equal<3>(diamond::kBrickSamples<3>);
  lower[2] += layer * diamond::Model<3>::kLayer;
  size[2] = diamond::Model<3>::kLayer + 1;
  for (std::size_t i = 0; i < diamond::n_points<3>(size); ++i) {
    const double value = model.value(lower + diamond::point_of<3>(size, i));  // or the nearest
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
  }
  return range;
}

void expect_ranges(const Volume& volume) {
  const diamond::Model<3> model = model_of(volume);
  constexpr std::size_t kLayers = diamond::Model<3>::kLayers;
  ASSERT_EQ(model.layer_ranges.size(), model.n_bricks() * kLayers);
  for (std::size_t brick = 0; brick < model.n_bricks(); ++brick)
    for (std::size_t layer = 0; layer < kLayers; ++layer) {
      const SampleRange expected = range_of(model, diamond::point_of<3>(model.brick_dims, brick),
                                            static_cast<std::int32_t>(layer));
      const SampleRange& found = model.layer_ranges[brick * kLayers + layer];
      ASSERT_EQ(found.low, expected.low) << "brick " << brick << ", layer " << layer;
      ASSERT_EQ(found.high, expected.high) << "brick " << brick << ", layer " << layer;
    }
}

TEST(layer_ranges, are_those_of_the_samples) {
  for (const Index3& dims : {Index3{{2, 2, 2}}, Index3{{33, 34, 9}}, Index3{{70, 40, 42}}}) {
    expect_ranges(noise_of<std::uint8_t>(dims));
    expect_ranges(noise_of<std::int16_t>(dims));
    expect_ranges(noise_of<float>(dims));
    expect_ranges(noise_of<double>(dims));
  }
}

TEST(layer_ranges, say_nothing_of_bricks_with_holes) {
  Volume volume = noise_of<float>({{70, 40, 42}});
  oracles::typed_samples<float>(volume)[0] = std::numeric_limits<float>::quiet_NaN();
  const diamond::Model<3> model = model_of(volume);
  EXPECT_EQ(model.layer_ranges.front().low, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(model.layer_ranges.front().high, std::numeric_limits<double>::infinity());
  EXPECT_GE(model.layer_ranges.back().low, 0);
}

/// Samples below and above a plane between two layers of them: each sign is that of its sample, and
/// only boxes that the plane meets are read.
void expect_signs_beside_a_plane(std::size_t axis, std::int32_t first_inside) {
  RegularGrid grid;
  grid.dims = {{71, 67, 35}};
  const Volume volume = oracles::volume_of<float>(
      grid, [&](const Index3& p) { return p[axis] >= first_inside ? 1.0 : 0.0; });
  const diamond::Model<3> model = model_of(volume);
  const diamond::Selection<3> selection(model, 0.5, 0);
  std::uint64_t n_read = 0;
  const diamond::SignField signs = diamond::sign_field(selection, {2}, n_read);
  std::size_t n_met = 1;
  for (std::size_t i = 0; i < 3; ++i)
    if (i != axis) n_met *= as_size(model.brick_dims[i]);
  EXPECT_EQ(n_read, n_met);
  const std::int32_t last_outside = first_inside - 1;
  for (std::int32_t z = 0; z < grid.dims[2]; ++z)
    for (std::int32_t y = 0; y < grid.dims[1]; ++y) {
      const bool is_crossed = (axis == 0 || (axis == 1 ? y : z) == last_outside);
      const bool may_cross = !signs.met_words(y, z).empty();
      ASSERT_TRUE(!is_crossed || may_cross) << y << " " << z;
      if (axis == 2) ASSERT_EQ(may_cross, z / 8 == last_outside / 8) << y << " " << z;
      if (!is_crossed) continue;
      // Edges end in the next rows, too.
      for (std::int32_t i = 0; i < 4; ++i) {
        const std::int32_t row_y = std::min(y + (i & 1), grid.dims[1] - 1);
        const std::int32_t row_z = std::min(z + (i >> 1), grid.dims[2] - 1);
        for (std::int32_t x = 0; x < grid.dims[0]; ++x) {
          if (axis == 0 && x / 32 < last_outside / 32) continue;  // nobody asks
          if (axis == 0 && x / 32 > first_inside / 32) continue;
          const std::uint32_t word = signs.words[signs.offset(as_size(x / 32), row_y, row_z)];
          const std::int32_t at = axis == 0 ? x : axis == 1 ? row_y : row_z;
          ASSERT_EQ((word >> (x % 32) & 1) != 0, at >= first_inside)
              << x << " " << row_y << " " << row_z;
        }
      }
    }
}

TEST(sign_field, is_that_of_the_samples_on_both_sides_of_a_plane) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const std::int32_t first_inside : {1, 7, 8, 9, 31, 32, 33, 34})
      expect_signs_beside_a_plane(axis, first_inside);
  for (const std::int32_t first_inside : {63, 64, 65, 66}) {
    expect_signs_beside_a_plane(0, first_inside);
    expect_signs_beside_a_plane(1, first_inside);
  }
  expect_signs_beside_a_plane(0, 70);
}

}  // namespace
}  // namespace lode
