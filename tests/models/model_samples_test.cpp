#include "lode/models/diamond/model_samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>

#include "lode/models/diamond/build.h"
#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"

namespace lode::diamond {
namespace {

/// Of all cells, whatever brick and whichever side of the even corner they lie on.
template <typename T>
void expect_corners(double hole, std::optional<double> nodata) {
  RegularGrid grid;
  grid.dims = {{35, 33, 66}};
  oracles::Random random(3);
  Volume volume = oracles::volume_of<T>(grid, [&](const Index3&) {
    return random.below(50) == 0 ? hole : std::floor(random.uniform(0, 200));
  });
  volume.info.nodata = nodata;
  Progress progress;
  const auto model = build<3>(*make_memory_source(volume), {.threads = {2}}, progress);
  ASSERT_TRUE(model) << model.error().message;
  const ModelSamples<3> samples(*model);
  const VolumeSamples expected(volume);
  for (std::int32_t z = 0; z + 1 < grid.dims[2]; ++z)
    for (std::int32_t y = 0; y + 1 < grid.dims[1]; ++y)
      for (std::int32_t x = 0; x + 1 < grid.dims[0]; ++x) {
        const CellField found(samples, {{x, y, z}}, 17);
        const CellField known(expected, {{x, y, z}}, 17);
        ASSERT_EQ(found.is_removed(), known.is_removed());
        for (std::size_t k = 0; k < 8; ++k)
          ASSERT_TRUE(found.at_corner(k) == known.at_corner(k) ||
                      (std::isnan(found.at_corner(k)) && std::isnan(known.at_corner(k))));
      }
}

TEST(model_samples, gives_the_corners_of_each_cell) {
  expect_corners<std::uint8_t>(5, std::nullopt);
  expect_corners<std::int16_t>(-1000, -1000);
  expect_corners<float>(std::numeric_limits<double>::quiet_NaN(), std::nullopt);
}

}  // namespace
}  // namespace lode::diamond
