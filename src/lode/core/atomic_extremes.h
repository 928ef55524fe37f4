#pragma once

#include <atomic>

namespace lode {

/// target = max(target, value), for threads that share it; NaN changes nothing.
template <typename T>
void raise_to(T& target, T value) {
  std::atomic_ref<T> atomic(target);
  T old = atomic.load(std::memory_order_relaxed);
  while (old < value && !atomic.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
  }
}

/// target = min(target, value), likewise.
template <typename T>
void lower_to(T& target, T value) {
  std::atomic_ref<T> atomic(target);
  T old = atomic.load(std::memory_order_relaxed);
  while (old > value && !atomic.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
  }
}

}  // namespace lode
