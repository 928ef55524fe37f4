#pragma once

// Numbers of few bits one after the other, the lowest bit first.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lode::insertions {

class PageBitWriter {
 public:
  /// `n_bits`: up to 64; the number has no more.
  void write(std::uint64_t number, int n_bits) {
    for (int done = 0; done < n_bits;) {
      if (n_free_ == 0) {
        bytes_.push_back(std::byte{0});
        n_free_ = 8;
      }
      const int n = std::min(n_free_, n_bits - done);
      const std::uint64_t part = (number >> done) & ((std::uint64_t{1} << n) - 1);
      bytes_.back() |= static_cast<std::byte>(part << (8 - n_free_));
      n_free_ -= n;
      done += n;
    }
  }
  /// Rice's code: number >> k times a 1, a 0, and k bits.
  void write_rice(std::uint32_t number, int k) {
    for (std::uint32_t i = number >> k; i > 0; --i) write(1, 1);
    write(0, 1);
    write(number & ((std::uint64_t{1} << k) - 1), k);
  }
  [[nodiscard]] std::vector<std::byte> take() && { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
  int n_free_ = 0;  ///< Bits of the last byte.
};

/// Reads what nobody vouches for: behind the end there are zeros, and is_past_end().
class PageBitReader {
 public:
  explicit PageBitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::uint64_t read(int n_bits) {
    std::uint64_t number = 0;
    for (int done = 0; done < n_bits;) {
      const int offset = static_cast<int>(at_ % 8);
      const int n = std::min(8 - offset, n_bits - done);
      const std::size_t at_byte = at_ / 8;
      const std::uint64_t byte =
          at_byte < bytes_.size() ? std::to_integer<std::uint64_t>(bytes_[at_byte]) : 0;
      number |= ((byte >> offset) & ((std::uint64_t{1} << n) - 1)) << done;
      at_ += static_cast<std::size_t>(n);
      done += n;
    }
    return number;
  }
  /// What comes back may be larger than was written where the bits are no such code.
  [[nodiscard]] std::uint64_t read_rice(int k) {
    std::uint64_t high = 0;
    while (!is_past_end() && read(1) != 0) ++high;
    return (high << k) | read(k);
  }
  [[nodiscard]] bool is_past_end() const { return at_ > 8 * bytes_.size(); }
  /// Whether all but the last byte's unused bits has been read.
  [[nodiscard]] bool is_at_end() const { return (at_ + 7) / 8 == bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;  ///< In bits.
};

inline constexpr int kMostRiceBits = 31;

/// The k that makes Rice's codes of these the shortest.
[[nodiscard]] inline int choose_rice_bits(std::span<const std::uint32_t> numbers) {
  const auto length = [&](int k) {
    std::uint64_t n_bits = 0;
    for (const std::uint32_t number : numbers)
      n_bits += (number >> k) + 1 + static_cast<std::uint64_t>(k);
    return n_bits;
  };
  int best = 0;
  for (int k = 1; k <= kMostRiceBits; ++k)
    if (length(k) < length(best)) best = k;
  return best;
}

}  // namespace lode::insertions
