#pragma once

#include <bit>
#include <cstdint>

namespace lode::tetra_mt {

/// The bits of a float32 (narrow) or float64 as a number, larger for a larger one; -0 is just below
/// +0.
[[nodiscard]] inline std::uint64_t to_ordered(double number, bool is_narrow) {
  if (is_narrow) {
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(number));
    return (bits >> 31) != 0 ? ~bits & 0xFFFFFFFFU : bits | 0x80000000U;
  }
  const auto bits = std::bit_cast<std::uint64_t>(number);
  return (bits >> 63) != 0 ? ~bits : bits | std::uint64_t{1} << 63;
}

/// `ordered`: of 32 bits where it is narrow.
[[nodiscard]] inline double from_ordered(std::uint64_t ordered, bool is_narrow) {
  if (is_narrow) {
    const auto bits = static_cast<std::uint32_t>(ordered);
    return static_cast<double>(
        std::bit_cast<float>((bits >> 31) != 0 ? bits & 0x7FFFFFFFU : ~bits));
  }
  return std::bit_cast<double>((ordered >> 63) != 0 ? ordered & ~(std::uint64_t{1} << 63)
                                                    : ~ordered);
}

[[nodiscard]] inline std::uint64_t largest_ordered(bool is_narrow) {
  return is_narrow ? 0xFFFFFFFFU : ~std::uint64_t{0};
}

}  // namespace lode::tetra_mt
