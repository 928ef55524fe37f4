#pragma once

#include <algorithm>
#include <array>
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

/// Rounds a range's ends outward to multiples of a power of two, at most 1/64 of its width, so that
/// they compress; but not beyond the whole field's range. Where one contains another, it still
/// does. An end that float32 cannot hold is infinite; the other is then rounded as for the widest
/// range.
inline void round_range(const std::array<float, 2>& whole, float& low, float& high) {
  const double width = static_cast<double>(high) - static_cast<double>(low);
  if (!(width > 0)) return;
  // The power of two in the width, without its mantissa.
  constexpr std::uint64_t kExponent = 0x7ff0000000000000U;
  const double power = std::isinf(width)
                           ? 0x1p128
                           : std::bit_cast<double>(std::bit_cast<std::uint64_t>(width) & kExponent);
  const double step = power / 64;
  const double steps = 64 / power;
  // Exact in double; where float32 is coarser than the step, these are multiples already.
  const double below = std::floor(static_cast<double>(low) * steps) * step;
  const double above = std::ceil(static_cast<double>(high) * steps) * step;
  const auto largest = static_cast<double>(std::numeric_limits<float>::max());
  const double infinity = std::numeric_limits<double>::infinity();
  const auto whole_low = static_cast<double>(whole[0]);
  const auto whole_high = static_cast<double>(whole[1]);
  low = static_cast<float>(std::max(below < -largest ? -infinity : below, whole_low)) + 0.0F;
  high = static_cast<float>(std::min(above > largest ? infinity : above, whole_high)) + 0.0F;
}

}  // namespace lode::diamond
