#pragma once

#include <cstdint>

namespace lode::test {

/// What the operating system or the allocator is made to do. The first ones are failures; the last
/// five are what every caller must put up with.
enum class Fault : std::uint8_t {
  memory,  ///< malloc() and its relatives, so operator new, and other libraries' allocations too.
  thread,
  open,
  read,
  write,
  sync,
  rename,  ///< And naming a file that has no name yet.
  resize,
  examine,  ///< Size, position, lock.
  short_read,
  short_write,
  interrupted_read,
  interrupted_write,
  late_read,  ///< By a few milliseconds.
};

[[nodiscard]] const char* name_of(Fault fault);
/// What messages should say of it; null where nothing fails.
[[nodiscard]] const char* message_of(Fault fault);

/// Which calls fail: number `first`, counted from 0 when it begins, and with `persists` all later
/// ones.
struct FaultPlan {
  Fault fault = Fault::memory;
  std::int64_t first = 0;
  bool persists = false;
};

struct FaultCount {
  std::int64_t n_calls = 0;
  std::int64_t n_failed = 0;
};

/// Whether this program stands between the library and the system: not where a sanitizer does.
[[nodiscard]] bool can_inject_faults();

/// From here to end_faults() the plan holds, on all threads. Calls that oneTBB and the C library
/// make for themselves are left alone: what they do without memory is not ours.
void begin_faults(const FaultPlan& plan);
FaultCount end_faults();

}  // namespace lode::test
