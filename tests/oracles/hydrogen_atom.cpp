#include "tests/oracles/hydrogen_atom.h"

#include <cmath>
#include <numbers>

#include "tests/oracles/typed_samples.h"

namespace lode::oracles {

double hydrogen_density(const Vec3d& point) {
  const double r2 = dot(point, point);
  const double angular = 3 * point[2] * point[2] - r2;
  return angular * angular * std::exp(-2 * std::sqrt(r2) / 3) / (81 * 81 * 6 * std::numbers::pi);
}

double largest_hydrogen_density() { return hydrogen_density({{0, 0, 6}}); }

Volume hydrogen_atom(std::int32_t n) {
  LODE_EXPECTS(n > 1);
  RegularGrid grid{.dims = {{n, n, n}}};
  for (std::size_t i = 0; i < 3; ++i) {
    grid.spacing[i] = 2 * kHydrogenHalfWidth / (n - 1);
    grid.origin[i] = -kHydrogenHalfWidth;
  }
  Volume volume = empty_volume(grid, ScalarType::uint8);
  volume.info.field_name = "hydrogen_atom";
  // From the middle outward, so that both sides have the same bits.
  const auto coordinate = [n](std::int32_t i) {
    return kHydrogenHalfWidth * (2 * i - (n - 1)) / (n - 1);
  };
  const double scale = 255 / largest_hydrogen_density();
  std::uint8_t* out = typed_samples<std::uint8_t>(volume).data();
  for (std::int32_t z = 0; z < n; ++z)
    for (std::int32_t y = 0; y < n; ++y)
      for (std::int32_t x = 0; x < n; ++x)
        *out++ = to_sample<std::uint8_t>(
            scale * hydrogen_density({{coordinate(x), coordinate(y), coordinate(z)}}));
  return volume;
}

}  // namespace lode::oracles
