#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lode {

/// The largest of a changing set of errors >= 0, each rounded up to the upper 16 bits of a float32
/// (at most 1/128 too large): counts per value and a bitmap of those that occur. All in O(1).
class ErrorCounts {
 public:
  ErrorCounts() : counts_(kValues, 0) {}

  void add(float error) {
    const std::size_t value = value_of(error);
    if (counts_[value]++ == 0) mark(value);
  }
  void remove(float error) {
    const std::size_t value = value_of(error);
    if (--counts_[value] != 0) return;
    words_[value / 64] &= ~(std::uint64_t{1} << (value % 64));
    if (words_[value / 64] == 0) summary_[value / 4096] &= ~(std::uint64_t{1} << (value / 64 % 64));
  }
  /// 0 where there is none.
  [[nodiscard]] float largest() const {
    for (std::size_t i = summary_.size(); i-- > 0;) {
      if (summary_[i] == 0) continue;
      const std::size_t word = i * 64 + last_bit(summary_[i]);
      return std::bit_cast<float>(static_cast<std::uint32_t>(word * 64 + last_bit(words_[word]))
                                  << 16);
    }
    return 0;
  }

 private:
  static constexpr std::size_t kValues = 0x7F81;  ///< Up to infinity.

  static std::size_t value_of(float error) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(error);
    return (bits >> 16) + ((bits & 0xFFFFU) != 0 ? 1U : 0U);
  }
  static std::size_t last_bit(std::uint64_t word) {
    return static_cast<std::size_t>(63 - std::countl_zero(word));
  }
  void mark(std::size_t value) {
    words_[value / 64] |= std::uint64_t{1} << (value % 64);
    summary_[value / 4096] |= std::uint64_t{1} << (value / 64 % 64);
  }

  std::vector<std::uint32_t> counts_;
  std::array<std::uint64_t, 512> words_{};
  std::array<std::uint64_t, 8> summary_{};
};

}  // namespace lode
