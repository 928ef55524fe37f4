#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace lode {

/// A set of numbers below kBuckets, one for each value of the upper 16 bits of a float32 >= 0.
class BucketBits {
 public:
  static constexpr std::size_t kBuckets = 0x7F81;  ///< Up to infinity.

  void set(std::size_t i) {
    words_[i / 64] |= std::uint64_t{1} << (i % 64);
    summary_[i / 4096] |= std::uint64_t{1} << (i / 64 % 64);
  }
  void reset(std::size_t i) {
    words_[i / 64] &= ~(std::uint64_t{1} << (i % 64));
    if (words_[i / 64] == 0) summary_[i / 4096] &= ~(std::uint64_t{1} << (i / 64 % 64));
  }
  void clear() {
    words_ = {};
    summary_ = {};
  }
  [[nodiscard]] bool is_empty() const {
    std::uint64_t any = 0;
    for (const std::uint64_t word : summary_) any |= word;
    return any == 0;
  }
  /// Of a set that is not empty.
  [[nodiscard]] std::size_t highest() const {
    std::size_t i = summary_.size() - 1;
    while (summary_[i] == 0) --i;
    const std::size_t word = i * 64 + last_bit(summary_[i]);
    return word * 64 + last_bit(words_[word]);
  }
  [[nodiscard]] std::size_t lowest() const {
    std::size_t i = 0;
    while (summary_[i] == 0) ++i;
    const std::size_t word = i * 64 + first_bit(summary_[i]);
    return word * 64 + first_bit(words_[word]);
  }

 private:
  static std::size_t last_bit(std::uint64_t word) {
    return static_cast<std::size_t>(63 - std::countl_zero(word));
  }
  static std::size_t first_bit(std::uint64_t word) {
    return static_cast<std::size_t>(std::countr_zero(word));
  }

  std::array<std::uint64_t, 512> words_{};
  std::array<std::uint64_t, 8> summary_{};
};

}  // namespace lode
