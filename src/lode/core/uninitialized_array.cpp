#include "lode/core/uninitialized_array.h"

#include <cstdlib>

#ifdef __linux__
#include <sys/mman.h>
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

}  // namespace lode
