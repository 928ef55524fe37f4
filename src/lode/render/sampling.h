#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "lode/core/vec.h"

namespace lode {

/// Mixes all bits (the finaliser of MurmurHash3): seeds depend on the pixel alone, never on the
/// thread, so a picture has the same bytes for any number of threads.
[[nodiscard]] constexpr std::uint32_t mix_bits(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x85ebca6bU;
  x ^= x >> 13;
  x *= 0xc2b2ae35U;
  x ^= x >> 16;
  return x;
}

/// A well-spread sequence in the unit cube, shifted at random per pixel: the additive recurrence
/// of the generalised golden ratio, in 32-bit fixed point so that it is exact.
class PixelSequence {
 public:
  /// `stream` tells apart the uses within one pixel (lens, light, sky).
  PixelSequence(std::uint32_t x, std::uint32_t y, std::uint32_t stream) {
    std::uint32_t seed = mix_bits(x + mix_bits(y + mix_bits(stream + 0x9e3779b9U)));
    for (std::uint32_t& shift : shifts_) shift = seed = mix_bits(seed + 0x9e3779b9U);
  }

  /// Point i, each coordinate in [0, 1).
  [[nodiscard]] std::array<float, 3> at(std::uint32_t i) const {
    std::array<float, 3> point{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t bits = shifts_[axis] + i * kSteps[axis];
      point[axis] = static_cast<float>(bits >> 8) * 0x1p-24f;
    }
    return point;
  }

 private:
  // 2^32 / g, / g², / g³ with g the real root of g⁴ = g + 1.
  static constexpr std::array<std::uint32_t, 3> kSteps{3518319155U, 2882110345U, 2360945575U};
  std::array<std::uint32_t, 3> shifts_{};
};

/// Two unit vectors that make a right-handed frame with the unit vector n.
struct Tangents {
  Vec3f first;
  Vec3f second;
};
[[nodiscard]] inline Tangents tangents_of(const Vec3f& n) {
  const float sign = std::copysign(1.0f, n[2]);
  const float a = -1.0f / (sign + n[2]);
  const float b = n[0] * n[1] * a;
  return {{{1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]}},
          {{b, sign + n[1] * n[1] * a, -n[1]}}};
}

/// A direction round n with density proportional to the cosine; u, v uniform in [0, 1).
[[nodiscard]] inline Vec3f cosine_direction(const Vec3f& n, float u, float v) {
  const Tangents t = tangents_of(n);
  const float radius = std::sqrt(u);
  const float angle = 2 * std::numbers::pi_v<float> * v;
  return t.first * (radius * std::cos(angle)) + t.second * (radius * std::sin(angle)) +
         n * std::sqrt(std::max(0.0f, 1 - u));
}

/// A unit vector near `axis`, uniform on a disc of `radius` at distance 1.
[[nodiscard]] inline Vec3f disc_direction(const Vec3f& axis, float radius, float u, float v) {
  const Tangents t = tangents_of(axis);
  const float r = radius * std::sqrt(u);
  const float angle = 2 * std::numbers::pi_v<float> * v;
  return normalized(axis + t.first * (r * std::cos(angle)) + t.second * (r * std::sin(angle)));
}

/// Maps u in [0, 1) to a tent of half width `radius` round 0: a soft pixel filter.
[[nodiscard]] inline float tent_offset(float u, float radius) {
  const float t = 2 * u - 1;
  return std::copysign(radius * (1 - std::sqrt(std::max(0.0f, 1 - std::abs(t)))), t);
}

}  // namespace lode
