#pragma once

#include <cstdint>
#include <optional>

namespace lode {

/// How much more memory the process comes to need from here on: of all its threads, as the system
/// counts what is resident. Where the system does not tell (/proc of Linux) there is no value. One
/// at a time.
class PeakMemory {
 public:
  PeakMemory();

  [[nodiscard]] std::optional<std::uint64_t> bytes() const;

 private:
  std::optional<std::uint64_t> before_;
};

}  // namespace lode
