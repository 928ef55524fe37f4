#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace lode::tetra_mt {

/// For numbers up to `largest`.
[[nodiscard]] inline int bits_for(std::size_t largest) {
  return static_cast<int>(std::bit_width(largest));
}

/// Numbers of few bits one after the other, the lowest bit first.
class BitWriter {
 public:
  /// `n_bits`: up to 32.
  void write(std::uint32_t number, int n_bits) {
    pending_ |= std::uint64_t{number} << n_pending_;
    n_pending_ += n_bits;
    if (n_pending_ < kFlushBits) return;
    for (int i = 0; i < kFlushBits; i += 8)
      bytes_.push_back(static_cast<std::uint8_t>(pending_ >> i));
    pending_ >>= kFlushBits;
    n_pending_ -= kFlushBits;
  }
  /// Goes on at a multiple of so many bits, which divides 8. Returns at which bit.
  std::size_t align_to(int unit) {
    const int n = (unit - n_pending_ % unit) % unit;
    write(0, n);
    return 8 * bytes_.size() + static_cast<std::size_t>(n_pending_);
  }
  /// Goes on at a whole byte. Returns which.
  std::size_t align() {
    for (; n_pending_ > 0; n_pending_ -= 8, pending_ >>= 8)
      bytes_.push_back(static_cast<std::uint8_t>(pending_));
    pending_ = 0;
    n_pending_ = 0;
    return bytes_.size();
  }
  /// All of another one; that one is empty then.
  void take_all(BitWriter& other) {
    for (const std::uint8_t byte : other.bytes_) write(byte, 8);
    write(static_cast<std::uint32_t>(other.pending_), other.n_pending_);
    other.bytes_.clear();
    other.pending_ = 0;
    other.n_pending_ = 0;
  }
  /// With as many zeros behind as readers may look at.
  [[nodiscard]] std::vector<std::uint8_t> take() && {
    align();
    bytes_.resize(bytes_.size() + sizeof(std::uint64_t));
    bytes_.shrink_to_fit();
    return std::move(bytes_);
  }

 private:
  static constexpr int kFlushBits = 32;

  std::vector<std::uint8_t> bytes_;
  std::uint64_t pending_ = 0;
  int n_pending_ = 0;
};

class BitReader {
 public:
  /// `bytes`: as BitWriter makes them.
  BitReader(const std::uint8_t* bytes, std::size_t first_byte)
      : bytes_(bytes), at_(8 * first_byte) {}

  [[nodiscard]] std::uint32_t read(int n_bits) {
    const std::uint64_t next = window();
    at_ += static_cast<std::size_t>(n_bits);
    return static_cast<std::uint32_t>(next & ((std::uint64_t{1} << n_bits) - 1));
  }
  /// What comes: 57 bits at least.
  [[nodiscard]] std::uint64_t window() const {
    std::uint64_t eight = 0;
    std::memcpy(&eight, bytes_ + at_ / 8, sizeof eight);
    return eight >> at_ % 8;
  }
  void skip(std::size_t n_bits) { at_ += n_bits; }
  /// In bits.
  [[nodiscard]] std::size_t at() const { return at_; }

 private:
  const std::uint8_t* bytes_;
  std::size_t at_;  ///< In bits.
};

}  // namespace lode::tetra_mt
