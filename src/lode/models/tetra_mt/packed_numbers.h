#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "lode/models/tetra_mt/bit_stream.h"
#include "lode/models/tetra_mt/ordered_bits.h"

namespace lode::tetra_mt {

/// How floats of a page are kept in memory, K together, exactly: of each of the K the bits, ordered
/// as the numbers are, from the least on, without the zeros that all end in. Numbers of a page are
/// near each other, so that these are fewer than a float has.
template <std::size_t K>
class PackedNumbers {
 public:
  PackedNumbers() = default;
  /// Of n times K: number(i, k). `is_narrow`: float32 holds them.
  template <typename Number>
  PackedNumbers(std::uint32_t n, bool is_narrow, const Number& number) : is_narrow_(is_narrow) {
    for (std::size_t k = 0; k < K && n > 0; ++k) {
      least_[k] = ~std::uint64_t{0};
      for (std::uint32_t i = 0; i < n; ++i) least_[k] = std::min(least_[k], ordered(number(i, k)));
      std::uint64_t any = 0;
      for (std::uint32_t i = 0; i < n; ++i) any |= ordered(number(i, k)) - least_[k];
      if (any == 0) continue;
      n_zeros_[k] = static_cast<std::uint8_t>(std::countr_zero(any));
      n_bits_[k] = static_cast<std::uint8_t>(std::bit_width(any >> n_zeros_[k]));
    }
  }

  /// Goes on at a whole byte, from which on they are read.
  template <typename Number>
  void write(std::uint32_t n, const Number& number, BitWriter& bits) const {
    bits.align();
    for (std::uint32_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < K; ++k) {
        const std::uint64_t rest = (ordered(number(i, k)) - least_[k]) >> n_zeros_[k];
        bits.write(static_cast<std::uint32_t>(rest), std::min<int>(n_bits_[k], kHalf));
        if (n_bits_[k] > kHalf)
          bits.write(static_cast<std::uint32_t>(rest >> kHalf), n_bits_[k] - kHalf);
      }
    bits.align();
  }

  /// The i-th K. `bytes`: from the first on, with as many behind as BitReader looks at.
  [[nodiscard]] std::array<double, K> read(const std::uint8_t* bytes, std::uint32_t i) const {
    std::size_t n_bits = 0;
    for (const std::uint8_t n : n_bits_) n_bits += n;
    BitReader bits(bytes, 0);
    bits.skip(n_bits * i);
    std::array<double, K> numbers{};
    for (std::size_t k = 0; k < K; ++k) {
      std::uint64_t rest = bits.read(std::min<int>(n_bits_[k], kHalf));
      if (n_bits_[k] > kHalf) rest |= std::uint64_t{bits.read(n_bits_[k] - kHalf)} << kHalf;
      numbers[k] = from_ordered(least_[k] + (rest << n_zeros_[k]), is_narrow_);
    }
    return numbers;
  }

 private:
  static constexpr int kHalf = 32;  ///< Bits that are read and written at once.

  [[nodiscard]] std::uint64_t ordered(double number) const {
    return to_ordered(number, is_narrow_);
  }

  std::array<std::uint64_t, K> least_{};  ///< Ordered.
  std::array<std::uint8_t, K> n_zeros_{};
  std::array<std::uint8_t, K> n_bits_{};
  bool is_narrow_ = false;
};

}  // namespace lode::tetra_mt
