#include "lode/core/peak_memory.h"

#include <malloc.h>

#include <fstream>
#include <string>

namespace lode {
namespace {

/// A line of /proc/self/status, in bytes.
std::optional<std::uint64_t> status_of(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != name) continue;
    std::uint64_t kilobytes = 0;
    if (status >> kilobytes) return kilobytes * 1024;
  }
  return {};
}

}  // namespace

PeakMemory::PeakMemory() {
  // What is free but kept would be used again, and not seen.
  malloc_trim(0);
  std::ofstream reset("/proc/self/clear_refs");
  reset << "5" << std::flush;
  if (reset) before_ = status_of("VmRSS:");
}

std::optional<std::uint64_t> PeakMemory::bytes() const {
  const auto peak = status_of("VmHWM:");
  if (!before_ || !peak) return {};
  return *peak > *before_ ? *peak - *before_ : 0;
}

}  // namespace lode
