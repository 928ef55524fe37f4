#include "tests/oracles/synthetic_volumes.h"

#include <cmath>
#include <limits>
#include <span>
#include <type_traits>

#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"

namespace lode::oracles {
namespace {

// x fastest, one thread: the order of calls is part of what noise() promises.
template <typename ValueAt>
Volume fill(const Index3& dims, ScalarType type, const ValueAt& value_at) {
  Volume volume = empty_volume(RegularGrid{.dims = dims}, type);
  visit_scalar_type(type, [&]<typename T>() {
    T* out = typed_samples<T>(volume).data();
    for (std::int32_t z = 0; z < dims[2]; ++z)
      for (std::int32_t y = 0; y < dims[1]; ++y)
        for (std::int32_t x = 0; x < dims[0]; ++x)
          *out++ = value_at.template operator()<T>(Index3{{x, y, z}});
  });
  return volume;
}

bool is_odd(const Index3& p) { return (p[0] + p[1] + p[2]) % 2 != 0; }

template <typename T>
T extreme(bool odd) {
  if constexpr (std::is_floating_point_v<T>)
    return (odd ? T(1) : T(-1)) * (std::numeric_limits<T>::max() / 4);
  return odd ? std::numeric_limits<T>::max() : std::numeric_limits<T>::lowest();
}

}  // namespace

Volume linear_ramp(const Index3& dims, ScalarType type, const Vec3d& slope, double offset) {
  return fill(dims, type, [&]<typename T>(const Index3& p) {
    return to_sample<T>(slope[0] * p[0] + slope[1] * p[1] + slope[2] * p[2] + offset);
  });
}

Volume constant(const Index3& dims, ScalarType type, double value) {
  return fill(dims, type, [&]<typename T>(const Index3&) { return to_sample<T>(value); });
}

Volume checkerboard(const Index3& dims, ScalarType type, double even, double odd) {
  return fill(dims, type,
              [&]<typename T>(const Index3& p) { return to_sample<T>(is_odd(p) ? odd : even); });
}

Volume checkerboard_of_extremes(const Index3& dims, ScalarType type) {
  return fill(dims, type, []<typename T>(const Index3& p) { return extreme<T>(is_odd(p)); });
}

Volume noise(const Index3& dims, const NoiseOptions& options) {
  Random random(options.seed);
  return fill(dims, options.type, [&]<typename T>(const Index3&) {
    return to_sample<T>(random.uniform(options.low, options.high));
  });
}

Volume integer_noise(const Index3& dims, const NoiseOptions& options) {
  Random random(options.seed);
  const double low = std::ceil(options.low);
  LODE_EXPECTS(options.high >= low);
  const auto n_levels = static_cast<std::uint64_t>(std::floor(options.high) - low) + 1;
  return fill(dims, options.type, [&]<typename T>(const Index3&) {
    return to_sample<T>(low + static_cast<double>(random.below(n_levels)));
  });
}

}  // namespace lode::oracles
