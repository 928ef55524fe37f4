#pragma once

#include <cmath>

#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"

namespace lode::test {

/// Smooth and noisy at once, so that every tolerance leaves leaves of many sizes.
template <typename T>
[[nodiscard]] Volume rough_volume(const Index3& dims, double hole_share) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{0.5, 2.0, 1.25}};
  grid.origin = {{-3, 2, 1}};
  grid.direction = {{Vec3d{{0, 1, 0}}, Vec3d{{1, 0, 0}}, Vec3d{{0, 0, 1}}}};
  oracles::Random random(1);
  return oracles::volume_of<T>(grid, [&](const Index3& p) {
    const double wave = std::sin(0.11 * p[0] + 0.05 * p[2]) * std::cos(0.13 * p[1] - 0.07 * p[2]);
    const double noise = p[0] > 20 ? random.uniform(0, 6) : 0;
    const bool is_hole = random.uniform(0, 1) < hole_share;
    return is_hole ? std::nan("") : 100 + 90 * wave + noise;
  });
}

}  // namespace lode::test
