#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <optional>

namespace lode {

/// The least float >= 0 for which fits(number) holds, where it holds for all that are larger, found
/// by halving; nothing where it does not for the largest either. `fits` is asked 33 times at most.
template <typename Fits>
[[nodiscard]] std::optional<double> least_float(const Fits& fits) {
  // Floats that are >= 0 are in the order of their bits.
  const auto number = [](std::uint32_t bits) {
    return static_cast<double>(std::bit_cast<float>(bits));
  };
  std::uint32_t low = 0;
  std::uint32_t high = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::max());
  if (!fits(number(high))) return {};
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    if (fits(number(middle)))
      high = middle;
    else
      low = middle + 1;
  }
  return number(high);
}

}  // namespace lode
