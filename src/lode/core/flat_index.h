#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "lode/core/uninitialized_array.h"

namespace lode {

/// A hash map from 64-bit keys to 32-bit numbers, open, at most 5/8 full, 12 bytes a slot. Nothing
/// moves on erase but entries; iteration is not offered.
class FlatIndex {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  FlatIndex() { resize(64); }

  [[nodiscard]] std::size_t size() const { return size_; }
  /// The number under a key, or kNone.
  [[nodiscard]] std::uint32_t find(std::uint64_t key) const {
    for (std::size_t i = slot_of(key);; i = (i + 1) & mask_)
      if (numbers_[i] == kNone || keys_[i] == key) return numbers_[i];
  }
  /// `key` must be new; `number` may not be kNone.
  void insert(std::uint64_t key, std::uint32_t number) {
    if (8 * (size_ + 1) > 5 * keys_.size()) resize(2 * keys_.size());
    put(key, number);
    ++size_;
  }
  /// Returns the number that was under `key`, or kNone.
  std::uint32_t erase(std::uint64_t key) {
    std::size_t hole = slot_of(key);
    while (numbers_[hole] != kNone && keys_[hole] != key) hole = (hole + 1) & mask_;
    const std::uint32_t number = numbers_[hole];
    if (number == kNone) return kNone;
    // Entries behind the hole move up, unless that were before where their search begins.
    for (std::size_t i = (hole + 1) & mask_; numbers_[i] != kNone; i = (i + 1) & mask_) {
      if (((i - slot_of(keys_[i])) & mask_) < ((i - hole) & mask_)) continue;
      keys_[hole] = keys_[i];
      numbers_[hole] = numbers_[i];
      hole = i;
    }
    numbers_[hole] = kNone;
    --size_;
    return number;
  }
  void clear() {
    numbers_.assign(numbers_.size(), kNone);
    size_ = 0;
  }
  [[nodiscard]] std::size_t n_bytes() const { return keys_.size() * 12; }

 private:
  [[nodiscard]] std::size_t slot_of(std::uint64_t key) const {
    key = (key ^ (key >> 32)) * 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(key ^ (key >> 32)) & mask_;
  }
  void put(std::uint64_t key, std::uint32_t number) {
    std::size_t i = slot_of(key);
    while (numbers_[i] != kNone) i = (i + 1) & mask_;
    keys_[i] = key;
    numbers_[i] = number;
  }
  void resize(std::size_t n) {
    const UninitializedArray<std::uint64_t> old_keys = std::exchange(keys_, {});
    const UninitializedArray<std::uint32_t> old_numbers = std::exchange(numbers_, {});
    keys_.resize(n);
    numbers_.assign(n, kNone);
    mask_ = n - 1;
    for (std::size_t i = 0; i < old_numbers.size(); ++i)
      if (old_numbers[i] != kNone) put(old_keys[i], old_numbers[i]);
  }

  UninitializedArray<std::uint64_t> keys_;
  UninitializedArray<std::uint32_t> numbers_;
  std::size_t mask_ = 0;
  std::size_t size_ = 0;
};

}  // namespace lode
