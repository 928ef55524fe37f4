#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "lode/delaunay/lattice_mesh.h"

namespace lode::delaunay {

/// A number >= 0 rounded up. Without branches: which way it goes is anyone's guess.
[[nodiscard]] inline float to_float_above(double value) {
  const auto nearest = static_cast<float>(value);
  const auto bits = std::bit_cast<std::uint32_t>(nearest);
  return std::bit_cast<float>(bits +
                              static_cast<std::uint32_t>(static_cast<double>(nearest) < value));
}

/// Any number, rounded up.
[[nodiscard]] inline double to_double_above(long double value) {
  const auto nearest = static_cast<double>(value);
  return static_cast<long double>(nearest) < value ? std::nextafter(nearest, HUGE_VAL) : nearest;
}

/// numerator / denominator, rounded up; both >= 0 and of 53 bits, the second > 0. Equal fractions
/// give equal results.
[[nodiscard]] inline double divided_up(std::int64_t numerator, std::int64_t denominator) {
  const auto d = static_cast<double>(denominator);
  const auto n = static_cast<double>(numerator);
  const double quotient = n / d;
  return std::fma(quotient, d, -n) < 0 ? std::nextafter(quotient, HUGE_VAL) : quotient;
}

/// Any number, rounded down.
[[nodiscard]] inline float to_float_below(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) > value
             ? std::nextafter(nearest, -std::numeric_limits<float>::infinity())
             : nearest;
}

/// As errors are kept where there are many: rounded up to 8 significant bits, by less than 1/128.
[[nodiscard]] inline float to_coarse_above(float error) {
  const auto bits = std::bit_cast<std::uint32_t>(error);
  return std::bit_cast<float>((bits + 0xFFFFU) & 0xFFFF0000U);
}

/// Largest error first, then first position.
[[nodiscard]] inline std::uint64_t priority_of(const LatticeTriangle& triangle) {
  return (std::uint64_t{std::bit_cast<std::uint32_t>(triangle.error)} << 32) | ~triangle.candidate;
}

}  // namespace lode::delaunay
