#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>

#include "lode/api/phase_watch.h"

namespace lode::cli {

enum class ProgressDisplay : std::uint8_t { off, terminal };

/// One line on stderr that shows the phase, how far it is, how fast, and what is left. Appears only
/// after a second, so that quick commands stay silent, and is redrawn at most ten times a second.
class ProgressBar {
 public:
  /// `off` draws nothing; `terminal` draws if stderr is one.
  explicit ProgressBar(ProgressDisplay display);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar() { clear(); }

  /// Callable from any thread.
  void update(std::string_view phase, double fraction, std::uint64_t n_bytes);
  /// Wipes the line, so that other text can be written to stderr.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  bool is_shown_ = false;
  bool is_enabled_ = false;
  Clock::time_point next_draw_;
  PhaseWatch watch_;
  std::mutex mutex_;
};

}  // namespace lode::cli
