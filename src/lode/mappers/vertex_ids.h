#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace lode {

/// Numbers 64-bit keys 0, 1, 2, ... in the order in which they are first asked for. Open
/// addressing: 4 bytes a slot, at most half of them used, and the keys.
class VertexIds {
 public:
  struct Found {
    std::uint32_t id = 0;
    bool is_new = false;
  };

  [[nodiscard]] std::size_t size() const { return keys_.size(); }
  [[nodiscard]] std::uint64_t key(std::uint32_t id) const { return keys_[id]; }
  /// By their numbers.
  [[nodiscard]] const std::vector<std::uint64_t>& keys() const { return keys_; }
  /// Forgets all keys, but keeps the memory for as many.
  void clear() {
    keys_.clear();
    std::fill(slots_.begin(), slots_.end(), 0U);
  }

  /// A key's number; none if it has not been asked for.
  [[nodiscard]] std::optional<std::uint32_t> find(std::uint64_t key) const {
    if (slots_.empty()) return std::nullopt;
    for (std::size_t slot = first_slot(key); slots_[slot] != 0;
         slot = (slot + 1) & (slots_.size() - 1))
      if (keys_[slots_[slot] - 1] == key) return slots_[slot] - 1;
    return std::nullopt;
  }
  Found find_or_add(std::uint64_t key) {
    if (2 * (keys_.size() + 1) > slots_.size()) grow();
    std::size_t slot = first_slot(key);
    for (; slots_[slot] != 0; slot = (slot + 1) & (slots_.size() - 1))
      if (keys_[slots_[slot] - 1] == key) return {slots_[slot] - 1, false};
    keys_.push_back(key);
    slots_[slot] = static_cast<std::uint32_t>(keys_.size());
    return {slots_[slot] - 1, true};
  }

 private:
  [[nodiscard]] std::size_t first_slot(std::uint64_t key) const {
    // Only the top bits of a product depend on all of the key; the shift brings in keys that differ
    // in high bits only.
    const std::uint64_t mixed = (key ^ (key >> 32)) * 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(mixed >> (64 - std::bit_width(slots_.size() - 1)));
  }
  void grow() {
    slots_.assign(slots_.empty() ? 64 : slots_.size() * 4, 0);
    for (std::uint32_t id = 0; id < keys_.size(); ++id) {
      std::size_t slot = first_slot(keys_[id]);
      while (slots_[slot] != 0) slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = id + 1;
    }
  }

  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> slots_;  ///< Id + 1; 0 is empty.
};

}  // namespace lode
