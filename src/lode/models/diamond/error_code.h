#pragma once

#include <bit>
#include <cstdint>
#include <limits>

namespace lode::diamond {

/// A nested error, rounded up to the upper 16 bits of a float32: at most 1/128 too large, never
/// too small, and ordered as the errors are. 0 and infinity are exact.
using ErrorCode = std::uint16_t;

inline constexpr ErrorCode kInfiniteError = 0x7F80;

/// The smallest float32 not below `error` >= 0.
[[nodiscard]] inline float float_up(double error) {
  const float f = static_cast<float>(error);
  if (static_cast<double>(f) >= error) return f;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(f) + 1);
}

[[nodiscard]] inline ErrorCode encode_error(float error) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(error);
  return static_cast<ErrorCode>((bits >> 16) + ((bits & 0xFFFFU) != 0 ? 1U : 0U));
}

[[nodiscard]] inline float decode_error(ErrorCode code) {
  return std::bit_cast<float>(std::uint32_t{code} << 16);
}

/// The largest code whose error is <= tolerance (>= 0): a node wants refining iff its code is
/// larger.
[[nodiscard]] inline ErrorCode tolerance_code(double tolerance) {
  if (tolerance >= static_cast<double>(decode_error(kInfiniteError - 1))) return kInfiniteError - 1;
  float f = static_cast<float>(tolerance);
  if (static_cast<double>(f) > tolerance)
    f = std::bit_cast<float>(std::bit_cast<std::uint32_t>(f) - 1);
  return static_cast<ErrorCode>(std::bit_cast<std::uint32_t>(f) >> 16);
}

}  // namespace lode::diamond
