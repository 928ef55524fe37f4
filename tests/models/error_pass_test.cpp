// What passes over bricks hold samples in does not change what they find.
#include "lode/models/diamond/error_pass.h"

#include "tests/models/stored_fixtures.h"

namespace lode::diamond {
namespace {

/// Own errors of all levels, and level 0's attributes.
struct Found {
  std::vector<UninitializedArray<ErrorCode>> errors;
  NodeLevel leaf;
};

template <typename V, int D>
Found found(const Model<D>& model) {
  Found f;
  OwnErrors own;
  for (int level = 0; level < model.shape.n_levels; ++level)
    f.errors.emplace_back(n_points<D>(model.shape.attribute_dims(level)), ErrorCode{0});
  for (auto& errors : f.errors) own.emplace_back(errors);
  f.leaf.error.resize(f.errors[0].size());
  f.leaf.low.resize(f.errors[0].size());
  f.leaf.high.resize(f.errors[0].size());
  Progress progress;
  EXPECT_TRUE((find_own_errors<D, V>(model, own, &f.leaf, nullptr, {2}, progress)));
  return f;
}

template <int D>
void expect_same(const Volume& volume) {
  const Model<D> model = test::built<D>(volume);
  ASSERT_TRUE(fits_in_steps(model));
  const Found steps = found<Step>(model);
  const Found floats = found<float>(model);
  const Found doubles = found<double>(model);
  EXPECT_TRUE(steps.errors == floats.errors);
  EXPECT_TRUE(steps.errors == doubles.errors);
  EXPECT_TRUE(steps.leaf.error == doubles.leaf.error);
  EXPECT_TRUE(steps.leaf.low == floats.leaf.low);
  EXPECT_TRUE(steps.leaf.low == doubles.leaf.low);
  EXPECT_TRUE(steps.leaf.high == doubles.leaf.high);
}

template <typename T>
Volume noise(const Index3& dims, ScalarType type, std::int64_t smallest, std::uint64_t width) {
  RegularGrid grid;
  grid.dims = dims;
  Volume volume = oracles::empty_volume(grid, type);
  oracles::Random random(3);
  for (T& v : oracles::typed_samples<T>(volume))
    v = static_cast<T>(smallest + static_cast<std::int64_t>(random.below(width)));
  oracles::typed_samples<T>(volume)[0] = static_cast<T>(smallest);
  return volume;
}

TEST(error_pass, steps_floats_and_doubles_find_the_same) {
  for (const Index3 dims : {Index3{{65, 33, 40}}, Index3{{2, 3, 2}}, Index3{{97, 34, 18}}}) {
    expect_same<3>(noise<std::uint8_t>(dims, ScalarType::uint8, 0, 256));
    expect_same<3>(noise<std::int16_t>(dims, ScalarType::int16, -1024, 4096));
    expect_same<3>(noise<std::uint16_t>(dims, ScalarType::uint16, 60000, 4000));
  }
  expect_same<2>(noise<std::uint8_t>({{300, 130, 1}}, ScalarType::uint8, 3, 250));
  expect_same<2>(noise<std::int16_t>({{129, 1, 257}}, ScalarType::int16, -2000, 2040));
}

TEST(error_pass, steps_are_for_small_ranges_without_holes) {
  const auto fits = [](const Volume& volume) { return fits_in_steps(test::built<3>(volume)); };
  Volume volume = noise<std::int16_t>({{9, 9, 9}}, ScalarType::int16, -30000, 100);
  const auto samples = oracles::typed_samples<std::int16_t>(volume);
  samples[5] = -30000 + 4095;
  EXPECT_TRUE(fits(volume));
  samples[5] = -30000 + 4096;
  EXPECT_FALSE(fits(volume));
  samples[5] = -29999;
  volume.info.nodata = -29999;
  EXPECT_FALSE(fits(volume));
  EXPECT_FALSE(fits(test::random_samples({{9, 9, 9}}, ScalarType::float32, test::Holes::none)));
}

}  // namespace
}  // namespace lode::diamond
