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
constexpr int kWidth = 30;
constexpr const char* kWipe = "\r\x1b[K";

}  // namespace

ProgressBar::ProgressBar(ProgressDisplay display)
    : is_enabled_(display == ProgressDisplay::terminal && ::isatty(STDERR_FILENO) == 1),
      next_draw_(Clock::now() + kDelay) {}

void ProgressBar::update(std::string_view phase, double fraction) {
  if (!is_enabled_) return;
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  if (now < next_draw_) return;
  next_draw_ = now + kInterval;
  is_shown_ = true;
  const double part = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  const int filled = static_cast<int>(part * kWidth);
  print_error(fmt::format("{}{:<20} [{:#<{}}{:.<{}}] {:3.0f} %", kWipe, phase, "", filled, "",
                          kWidth - filled, 100 * part));
}

void ProgressBar::clear() {
  const std::lock_guard lock(mutex_);
  if (!is_shown_) return;
  is_shown_ = false;
  print_error(kWipe);
}

}  // namespace lode::cli
