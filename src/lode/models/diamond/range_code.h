#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace lode::diamond {

/// The next number towards +infinity, of any but +infinity and NaN.
template <typename Bits, typename F>
[[nodiscard]] inline F next_up(F x) {
  if (x == F(0)) return std::numeric_limits<F>::denorm_min();
  const Bits bits = std::bit_cast<Bits>(x);
  return std::bit_cast<F>(static_cast<Bits>(x > F(0) ? bits + 1 : bits - 1));
}
[[nodiscard]] inline double next_up(double x) { return next_up<std::uint64_t>(x); }
[[nodiscard]] inline float next_up(float x) { return next_up<std::uint32_t>(x); }

/// value - reference as float32, rounded up: an upper end of a range (see NodeLevel). -infinity
/// stays what it is, and -0 becomes 0: ends of either sign would be equal, but not the same bytes.
[[nodiscard]] inline float range_up(double value, double reference) {
  double difference = value - reference;
  if (std::isinf(difference)) return static_cast<float>(difference);
  if (reference != 0) difference = next_up(difference);
  const float f = static_cast<float>(difference);
  return (static_cast<double>(f) >= difference ? f : next_up(f)) + 0.0F;
}

/// Likewise rounded down: a lower end.
[[nodiscard]] inline float range_down(double value, double reference) {
  return -range_up(-value, -reference);
}

}  // namespace lode::diamond
