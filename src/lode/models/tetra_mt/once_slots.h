#pragma once

#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

namespace lode::tetra_mt {

/// Things that come one by one, to stay: one thread at a time puts, any look.
template <typename T>
class OnceSlots {
 public:
  explicit OnceSlots(std::size_t n) : slots_(n) {}
  OnceSlots(const OnceSlots&) = delete;
  OnceSlots& operator=(const OnceSlots&) = delete;
  ~OnceSlots() {
    for (auto& slot : slots_) delete slot.load(std::memory_order_relaxed);
  }

  /// None as long as nothing was put there.
  [[nodiscard]] const T* at(std::size_t i) const {
    return slots_[i].load(std::memory_order_acquire);
  }
  /// Expects nothing there. Of different slots also from several threads.
  const T& put(std::size_t i, T thing) {
    const T* const made = new T(std::move(thing));
    slots_[i].store(made, std::memory_order_release);
    ++n_;
    return *made;
  }
  [[nodiscard]] std::size_t size() const { return slots_.size(); }
  /// How many have been put.
  [[nodiscard]] std::size_t n_there() const { return n_; }

 private:
  std::vector<std::atomic<const T*>> slots_;
  std::atomic<std::size_t> n_{0};
};

}  // namespace lode::tetra_mt
