// The program's memory: vectors grow in the library and in others, in pages that the kernel clears
// one after the other as they are first written to. Of large blocks it is asked for huge ones, of
// which there are far fewer.
#include <cstddef>
#include <cstdlib>
#include <new>

#include "lode/api/memory.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

void* operator new(std::size_t n) {
  for (;;) {
    if (void* memory = std::malloc(n > 0 ? n : 1); memory != nullptr) {
      lode::prefer_huge_pages(memory, n);
      return memory;
    }
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*n*/) noexcept { std::free(memory); }

#endif
