#include "lode/core/uninitialized_array.h"

#include <cstdlib>
#include <memory>

#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace lode {

void* allocate_large(std::size_t n_bytes) {
  constexpr std::size_t kHugePage = std::size_t{1} << 21;
  const bool is_large = n_bytes >= kHugePage;
  if (is_large && n_bytes > static_cast<std::size_t>(-1) - kHugePage) throw std::bad_alloc();
  const std::size_t rounded = (n_bytes + kHugePage - 1) / kHugePage * kHugePage;
  void* memory = is_large ? std::aligned_alloc(kHugePage, rounded) : std::malloc(n_bytes);
  if (memory == nullptr && n_bytes > 0) throw std::bad_alloc();
#ifdef __linux__
  if (is_large) madvise(memory, rounded, MADV_HUGEPAGE);  // no harm where it is refused
#endif
  return memory;
}

void free_large(void* memory) noexcept { std::free(memory); }

void prefer_huge_pages(void* memory, std::size_t n_bytes) {
#ifdef __linux__
  constexpr std::size_t kLeast = std::size_t{4} << 20;
  if (n_bytes < kLeast) return;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  std::size_t left = n_bytes;
  if (std::align(page, page, memory, left) == nullptr) return;
  madvise(memory, left / page * page, MADV_HUGEPAGE);  // no harm where it is refused
#else
  static_cast<void>(memory);
  static_cast<void>(n_bytes);
#endif
}

void bring_in(void* memory, std::size_t n_bytes) {
#if defined(__linux__) && defined(MADV_POPULATE_WRITE)
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  std::size_t left = n_bytes;
  if (std::align(page, page, memory, left) == nullptr) return;
  madvise(memory, left / page * page, MADV_POPULATE_WRITE);
#else
  static_cast<void>(memory);
  static_cast<void>(n_bytes);
#endif
}

}  // namespace lode
