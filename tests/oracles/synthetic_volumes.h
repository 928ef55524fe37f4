#pragma once

#include <cstdint>

#include "lode/core/scalar_type.h"
#include "lode/core/vec.h"
#include "lode/core/volume.h"

namespace lode::oracles {

// Volumes that provoke: on a grid with unit spacing at the origin, the same bytes on every machine.
// Integer types round to nearest and clamp.

/// slope · index + offset. Linear, so every error of its hierarchy is zero (up to rounding).
[[nodiscard]] Volume linear_ramp(const Index3& dims, ScalarType type, const Vec3d& slope,
                                 double offset = 0);

[[nodiscard]] Volume constant(const Index3& dims, ScalarType type, double value);

/// `even` where x + y + z is even, `odd` elsewhere: the largest differences everywhere.
[[nodiscard]] Volume checkerboard(const Index3& dims, ScalarType type, double even, double odd);

/// A checkerboard of the type's lowest and highest integers; floating types get a quarter of
/// their largest value with either sign, so that differences of two samples stay finite.
[[nodiscard]] Volume checkerboard_of_extremes(const Index3& dims, ScalarType type);

struct NoiseOptions {
  ScalarType type = ScalarType::float32;
  std::uint64_t seed = 1;
  double low = 0;   ///< Samples are uniform on [low, high);
  double high = 1;  ///< integer types therefore reach both ends half as often.
};

[[nodiscard]] Volume noise(const Index3& dims, const NoiseOptions& options = {});

/// Uniform integers low..high (inclusive) as samples: few levels, so that ties are everywhere.
[[nodiscard]] Volume integer_noise(const Index3& dims, const NoiseOptions& options);

}  // namespace lode::oracles
