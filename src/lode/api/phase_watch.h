#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace lode {

/// What reports of progress say of a phase as time goes on: how fast it is, and when it ends.
class PhaseWatch {
 public:
  struct Outlook {
    std::uint64_t n_bytes_done = 0;        ///< 0 where the phase does not count bytes.
    std::optional<double> bytes_a_second;  ///< Since the phase began, or was gone on with;
    std::optional<double> seconds_left;    ///< none before there is something to go by.
  };

  /// As Progress's callback is told, at a time in seconds.
  Outlook update(std::string_view phase, double fraction, std::uint64_t n_bytes, double now) {
    if (phase != phase_ || fraction < first_) {
      phase_ = phase;
      first_ = fraction;
      begun_ = now;
    }
    Outlook outlook;
    const auto all = static_cast<double>(n_bytes);
    outlook.n_bytes_done = static_cast<std::uint64_t>(fraction * all);
    const double seconds = now - begun_;
    const double done = fraction - first_;
    if (seconds < kSecondsToGoBy || !(done > 0)) return outlook;
    if (n_bytes > 0) outlook.bytes_a_second = done * all / seconds;
    outlook.seconds_left = seconds * (1 - fraction) / done;
    return outlook;
  }

 private:
  static constexpr double kSecondsToGoBy = 1;

  std::string phase_;
  double first_ = 0;  ///< Fraction of its first report.
  double begun_ = 0;
};

}  // namespace lode
