#include "lode/core/progress.h"

namespace lode {

void Progress::report(std::string_view phase, double fraction, std::uint64_t n_bytes) {
  if (!callback_ || reporting_.test_and_set(std::memory_order_acquire)) return;
  callback_(phase, fraction, n_bytes);
  reporting_.clear(std::memory_order_release);
}

Error cancelled_error() { return Error{"cancelled"}; }

}  // namespace lode
