#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "lode/core/result.h"

namespace lode {

/// base + k interval from above `lowest` (or from it on) up to `highest`, rising strictly. Fails
/// where these are more than a million, or so many steps from the base that doubles do not count
/// them.
enum class LowestLevel : std::uint8_t { above, from };
[[nodiscard]] inline Result<std::vector<double>> levels_between(double base, double interval,
                                                                double lowest, double highest,
                                                                LowestLevel start) {
  constexpr double kMostSteps = 0x1p52;
  constexpr double kMost = 1e6;
  const double low = (lowest - base) / interval;
  const double first = start == LowestLevel::from ? std::ceil(low) : std::floor(low) + 1;
  const double last = std::floor((highest - base) / interval);
  if (!(std::abs(first) <= kMostSteps && std::abs(last) <= kMostSteps && last - first < kMost))
    return fail(
        "expected at most {} contours from {} to {}, and fewer than 2^52 steps from {}, got "
        "an interval of {}",
        kMost, lowest, highest, base, interval);
  std::vector<double> levels;
  const auto n = static_cast<std::int64_t>(last - first) + 1;
  for (std::int64_t i = 0; i < n; ++i) {
    const double level = base + (first + static_cast<double>(i)) * interval;
    if (levels.empty() || level > levels.back()) levels.push_back(level);
  }
  return levels;
}

}  // namespace lode
