#pragma once

#include <algorithm>
#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace lode {

/// Memory that is asked for in huge pages where it is large: whoever reads it here and there misses
/// few addresses (bench/refine, M apply/s on gaussians40_257: 1.2 times). Throws std::bad_alloc.
[[nodiscard]] void* allocate_large(std::size_t n_bytes);
void free_large(void* memory) noexcept;

/// Asks for huge pages for memory that nobody has written to yet, where it is large.
void prefer_huge_pages(void* memory, std::size_t n_bytes);

/// Has the system give pages for memory that nobody has written to yet, as the first write to each
/// would. Nothing happens where it cannot do so ahead of them.
void bring_in(void* memory, std::size_t n_bytes);

/// vector.resize(n), which takes new memory in huge pages: there are far fewer of them to be given
/// when it is first written to.
template <typename T>
void resize_large(std::vector<T>& vector, std::size_t n) {
  if (n > vector.capacity()) {
    vector.reserve(vector.empty() ? n : std::max(n, 2 * vector.capacity()));
    prefer_huge_pages(vector.data() + vector.size(), (n - vector.size()) * sizeof(T));
  }
  vector.resize(n);
}

/// Leaves elements of trivial types indeterminate where a vector would set them to zero.
template <typename T>
struct UninitializedAllocator {
  using value_type = T;

  UninitializedAllocator() = default;
  template <typename U>
  explicit UninitializedAllocator(const UninitializedAllocator<U>& /*other*/) {}

  [[nodiscard]] T* allocate(std::size_t n) {
    static_assert(alignof(T) <= alignof(std::max_align_t));
    if (n > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_array_new_length();
    return static_cast<T*>(allocate_large(n * sizeof(T)));
  }
  void deallocate(T* memory, std::size_t /*n*/) noexcept { free_large(memory); }
  friend bool operator==(const UninitializedAllocator&, const UninitializedAllocator&) {
    return true;
  }

  template <typename U>
  void construct(U* p) {
    ::new (static_cast<void*>(p)) U;
  }
  template <typename U, typename... Arguments>
  void construct(U* p, Arguments&&... arguments) {
    ::new (static_cast<void*>(p)) U(std::forward<Arguments>(arguments)...);
  }
};

/// A vector whose resize() writes nothing: what is made to be overwritten comes into memory with
/// the threads that do so, and is not written twice.
template <typename T>
using UninitializedArray = std::vector<T, UninitializedAllocator<T>>;

/// resize() for contents that are not needed any more: does not copy them where it must grow.
template <typename T>
void resize_anew(UninitializedArray<T>& array, std::size_t n) {
  if (n > array.capacity()) array = UninitializedArray<T>();
  array.resize(n);
}

}  // namespace lode
