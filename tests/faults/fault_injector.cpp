#include "tests/faults/fault_injector.h"

#include <dlfcn.h>
#include <execinfo.h>
#include <link.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string_view>

#include "tests/faults/interposed.h"

namespace lode::test {
namespace {

struct FaultKind {
  const char* name;
  int code;  ///< 0: nothing fails.
};

constexpr std::array<FaultKind, 14> kKinds = {{{"memory", ENOMEM},
                                               {"thread", EAGAIN},
                                               {"open", EMFILE},
                                               {"read", EIO},
                                               {"write", ENOSPC},
                                               {"sync", EIO},
                                               {"rename", EACCES},
                                               {"resize", ENOSPC},
                                               {"examine", EIO},
                                               {"short read", 0},
                                               {"short write", 0},
                                               {"interrupted read", 0},
                                               {"interrupted write", 0},
                                               {"late read", 0}}};

constexpr int kNone = -1;

std::atomic<int> armed{kNone};
std::atomic<std::int64_t> first_failing{0};
std::atomic<bool> is_persistent{false};
std::atomic<std::int64_t> n_calls{0};
std::atomic<std::int64_t> n_failed{0};

/// Where the code of a library lies that is left alone.
struct CodeRange {
  std::uintptr_t begin = 0;
  std::uintptr_t end = 0;
};
std::array<CodeRange, 16> spared;
std::size_t n_spared = 0;

int note_spared(dl_phdr_info* info, std::size_t, void*) {
  const std::string_view path = info->dlpi_name;
  const std::string_view file = path.substr(path.rfind('/') + 1);
  if (!file.starts_with("libtbb") && !file.starts_with("libc.") && !file.starts_with("ld-"))
    return 0;
  for (int i = 0; i < info->dlpi_phnum && n_spared < spared.size(); ++i) {
    const auto& part = info->dlpi_phdr[i];
    if (part.p_type != PT_LOAD || (part.p_flags & PF_X) == 0) continue;
    const std::uintptr_t begin = info->dlpi_addr + part.p_vaddr;
    spared[n_spared++] = {begin, begin + part.p_memsz};
  }
  return 0;
}

bool is_spared(const void* caller) {
  const auto at = reinterpret_cast<std::uintptr_t>(caller);
  for (std::size_t i = 0; i < n_spared; ++i)
    if (at >= spared[i].begin && at < spared[i].end) return true;
  return false;
}

/// Where nobody can help from outside: nlohmann::json takes memory to free a document, in a
/// destructor, which ends the program, and Embree 3 frees what it has not made.
bool is_out_of_reach() {
  std::array<void*, 48> frames{};
  const int n = backtrace(frames.data(), static_cast<int>(frames.size()));
  for (int i = 0; i < n; ++i) {
    Dl_info place{};
    if (dladdr(frames[static_cast<std::size_t>(i)], &place) == 0) continue;
    if (place.dli_sname != nullptr && std::strstr(place.dli_sname, "json_value7destroy") != nullptr)
      return true;
    if (std::strstr(place.dli_fname, "libembree") != nullptr) return true;
  }
  return false;
}

}  // namespace

const char* name_of(Fault fault) { return kKinds[static_cast<std::size_t>(fault)].name; }

const char* message_of(Fault fault) {
  if (fault == Fault::memory) return "memory";
  const int code = kKinds[static_cast<std::size_t>(fault)].code;
  return code == 0 ? nullptr : std::strerror(code);
}

bool must_fail(Fault fault, const void* caller) {
  if (armed.load(std::memory_order_relaxed) != static_cast<int>(fault) || is_spared(caller))
    return false;
  const std::int64_t number = n_calls.fetch_add(1, std::memory_order_relaxed);
  const std::int64_t first = first_failing.load(std::memory_order_relaxed);
  if (number < first || (number > first && !is_persistent.load(std::memory_order_relaxed)))
    return false;
  if (fault == Fault::memory && is_out_of_reach()) return false;
  n_failed.fetch_add(1, std::memory_order_relaxed);
  if (const int code = kKinds[static_cast<std::size_t>(fault)].code; code != 0) errno = code;
  return true;
}

void begin_faults(const FaultPlan& plan) {
  if (n_spared == 0) dl_iterate_phdr(note_spared, nullptr);
  is_out_of_reach();  // the first backtrace takes memory
  first_failing = plan.first;
  is_persistent = plan.persists;
  n_calls = 0;
  n_failed = 0;
  armed = static_cast<int>(plan.fault);
}

FaultCount end_faults() {
  armed = kNone;
  return {n_calls, n_failed};
}

}  // namespace lode::test
