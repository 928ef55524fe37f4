#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lode::delaunay {

/// A set of packed nodes that tells how many come before one.
class NumberedNodes {
 public:
  explicit NumberedNodes(std::uint32_t last) : words_(std::size_t{last / 64} + 1, 0) {}

  void add(std::uint32_t node) { words_[node / 64] |= bit_of(node); }
  /// The same, of several threads at once.
  void add_shared(std::uint32_t node) {
    const std::atomic_ref<std::uint64_t> word(words_[node / 64]);
    if ((word.load(std::memory_order_relaxed) & bit_of(node)) == 0)
      word.fetch_or(bit_of(node), std::memory_order_relaxed);
  }
  /// Counts what has been added.
  std::uint32_t number() {
    n_before_.reserve(words_.size());
    std::uint32_t n = 0;
    for (const std::uint64_t word : words_) {
      n_before_.push_back(n);
      n += static_cast<std::uint32_t>(std::popcount(word));
    }
    return n;
  }
  [[nodiscard]] std::uint32_t number_of(std::uint32_t node) const {
    const std::uint64_t below = words_[node / 64] & (bit_of(node) - 1);
    return n_before_[node / 64] + static_cast<std::uint32_t>(std::popcount(below));
  }
  [[nodiscard]] std::size_t n_words() const { return words_.size(); }
  /// Calls visit(node, number) for those of a word.
  template <typename Visit>
  void for_each_in(std::size_t word, const Visit& visit) const {
    std::uint32_t number = n_before_[word];
    for (std::uint64_t left = words_[word]; left != 0; left &= left - 1)
      visit(static_cast<std::uint32_t>(64 * word) +
                static_cast<std::uint32_t>(std::countr_zero(left)),
            number++);
  }

 private:
  [[nodiscard]] static std::uint64_t bit_of(std::uint32_t node) {
    return std::uint64_t{1} << (node % 64);
  }

  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> n_before_;
};

}  // namespace lode::delaunay
