#pragma once

#include "lode/api/dataset.h"

namespace lode::cli {

/// While it lives, Ctrl-C and SIGTERM cancel `progress` instead of ending the process, so that
/// the command can take its temporary files away. At most one at a time.
class SignalGuard {
 public:
  explicit SignalGuard(Progress& progress);
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;
  ~SignalGuard();

  /// The signal that came, or 0.
  [[nodiscard]] static int received();
};

}  // namespace lode::cli
