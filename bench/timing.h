#pragma once

#include <time.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace lode::bench {

using Clock = std::chrono::steady_clock;

[[nodiscard]] inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What this process has used of its processors. Unlike the clock it does not count what others
/// take away on a shared machine.
[[nodiscard]] inline double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Of an odd number of them.
[[nodiscard]] inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Median of seven calls of `work`, which returns the seconds that count.
template <typename Work>
[[nodiscard]] double median_seconds(const Work& work) {
  std::vector<double> seconds;
  for (int i = 0; i < 7; ++i) seconds.push_back(work());
  return median(seconds);
}

}  // namespace lode::bench
