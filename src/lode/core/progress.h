#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string_view>

#include "lode/core/result.h"

namespace lode {

/// Carries progress out of a long operation and cancellation into it. Passed by reference;
/// a default-made one reports to nobody and is never cancelled. All members may be called from
/// any thread; the callback is called from one thread at a time.
class Progress {
 public:
  /// phase: a few words; fraction: 0..1 of that phase; n_bytes: of the data that all of it goes
  /// through, 0 where that is not known or means nothing.
  using Callback =
      std::function<void(std::string_view phase, double fraction, std::uint64_t n_bytes)>;

  Progress() = default;
  explicit Progress(Callback callback) : callback_(std::move(callback)) {}

  /// Asks the operation to stop soon; safe in a signal handler.
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool is_cancelled() const noexcept {
    return cancelled_.load(std::memory_order_relaxed);
  }
  void report(std::string_view phase, double fraction, std::uint64_t n_bytes = 0);

 private:
  Callback callback_;
  std::atomic<bool> cancelled_{false};
  std::atomic_flag reporting_;
};

/// The Error every cancelled operation returns.
[[nodiscard]] Error cancelled_error();

}  // namespace lode
