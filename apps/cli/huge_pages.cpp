// The program's memory: vectors grow in the library and in others, in pages that the kernel clears
// one after the other as they are first written to. Of large blocks it is asked for huge ones, of
// which there are far fewer.
#include <cstddef>
#include <cstdlib>
#include <new>

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#include <sys/mman.h>

#include <memory>

namespace {

constexpr std::size_t kLeast = std::size_t{4} << 20;
constexpr std::size_t kPage = 4096;

void* allocate(std::size_t n) {
  void* memory = std::malloc(n > 0 ? n : 1);
  if (memory == nullptr || n < kLeast) return memory;
  void* first = memory;
  std::size_t left = n;
  if (std::align(kPage, kPage, first, left) != nullptr)
    madvise(first, left / kPage * kPage, MADV_HUGEPAGE);  // no harm where it is refused
  return memory;
}

}  // namespace

void* operator new(std::size_t n) {
  for (;;) {
    if (void* memory = allocate(n); memory != nullptr) return memory;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*n*/) noexcept { std::free(memory); }
#endif
