#include "progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "text.h"

namespace lode::cli {
namespace {

constexpr auto kDelay = std::chrono::seconds(1);
constexpr auto kInterval = std::chrono::milliseconds(100);
constexpr int kWidth = 20;
constexpr const char* kWipe = "\r\x1b[K";

/// 1.2 of 4.3 GB, 75 MB/s, 0:41 left
std::string describe(const PhaseWatch::Outlook& outlook, std::uint64_t n_bytes) {
  std::string text;
  if (n_bytes > 0)
    text += fmt::format("  {} of {}", format_bytes(outlook.n_bytes_done), format_bytes(n_bytes));
  if (outlook.bytes_a_second)
    text +=
        fmt::format(", {}/s", format_bytes(static_cast<std::uint64_t>(*outlook.bytes_a_second)));
  if (outlook.seconds_left) {
    const auto seconds = static_cast<std::uint64_t>(std::ceil(*outlook.seconds_left));
    text += fmt::format("{} {}:{:02} left", text.empty() ? " " : ",", seconds / 60, seconds % 60);
  }
  return text;
}

}  // namespace

ProgressBar::ProgressBar(ProgressDisplay display)
    : is_enabled_(display == ProgressDisplay::terminal && ::isatty(STDERR_FILENO) == 1),
      next_draw_(Clock::now() + kDelay) {}

void ProgressBar::update(std::string_view phase, double fraction, std::uint64_t n_bytes) {
  if (!is_enabled_) return;
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  const double part = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  const PhaseWatch::Outlook outlook = watch_.update(
      phase, part, n_bytes, std::chrono::duration<double>(now.time_since_epoch()).count());
  if (now < next_draw_) return;
  next_draw_ = now + kInterval;
  is_shown_ = true;
  const int filled = static_cast<int>(part * kWidth);
  print_error(fmt::format("{}{:<12} [{:#<{}}{:.<{}}] {:3.0f} %{}", kWipe, phase, "", filled, "",
                          kWidth - filled, 100 * part, describe(outlook, n_bytes)));
}

void ProgressBar::clear() {
  const std::lock_guard lock(mutex_);
  if (!is_shown_) return;
  is_shown_ = false;
  print_error(kWipe);
}

}  // namespace lode::cli
