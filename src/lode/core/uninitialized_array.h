#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace lode {

/// Leaves elements of trivial types indeterminate where a vector would set them to zero.
template <typename T>
struct UninitializedAllocator : std::allocator<T> {
  template <typename U>
  struct rebind {
    using other = UninitializedAllocator<U>;
  };
  using std::allocator<T>::allocator;

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

}  // namespace lode
