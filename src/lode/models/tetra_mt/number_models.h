#pragma once

// Numbers as bits, each with a model of its own: docs/format.md, section 7. `Coder` is RangeWriter
// or RangeReader: the first codes what it is given, both return what was coded.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "lode/models/tetra_mt/range_coder.h"

namespace lode::tetra_mt {

/// 0, -1, 1, -2, 2, ... as 0, 1, 2, 3, 4, ...
[[nodiscard]] constexpr std::uint32_t folded(std::int32_t number) {
  return static_cast<std::uint32_t>(number) << 1 ^ static_cast<std::uint32_t>(number >> 31);
}
[[nodiscard]] constexpr std::int32_t unfolded(std::uint32_t code) {
  return static_cast<std::int32_t>(code >> 1 ^ (0U - (code & 1)));
}

/// The n lowest bits of a number, all equally probable.
template <typename Coder>
std::uint64_t code_plain(Coder& coder, int n, std::uint64_t given) {
  std::uint64_t found = 0;
  while (n > 0) {
    const int step = std::min(n, 16);
    n -= step;
    const auto part = static_cast<std::uint32_t>(given >> n & ((1U << step) - 1));
    found = found << step | coder.one_of(1U << step, part);
  }
  return found;
}

/// A number below n, all equally probable; a reader may find one above where bytes are wrong.
template <typename Coder>
std::uint64_t code_below(Coder& coder, std::uint64_t n, std::uint64_t given) {
  const int n_plain = std::max(0, static_cast<int>(std::bit_width(n - 1)) - 16);
  const auto n_tops = static_cast<std::uint32_t>((n - 1) >> n_plain) + 1;
  const std::uint64_t top = coder.one_of(n_tops, static_cast<std::uint32_t>(given >> n_plain));
  return top << n_plain | code_plain(coder, n_plain, given);
}

/// A number of kBits bits, from the highest one on, each in view of those before.
template <int kBits>
class SymbolModel {
 public:
  template <typename Coder>
  std::uint32_t code(Coder& coder, std::uint32_t given) {
    Held held(coder);
    std::uint32_t place = 1;
    for (int i = kBits - 1; i >= 0; --i)
      place = 2 * place + (held.bit(bits_[place], (given >> i & 1) != 0) ? 1 : 0);
    return place - (1U << kBits);
  }

 private:
  std::array<BitModel, std::size_t{1} << kBits> bits_;
};

/// The bits of x behind its highest one, of which there are n: the first three of them in view of
/// those before, the rest plain.
template <typename Coder>
std::uint64_t code_behind_highest(Coder& coder, std::array<BitModel, 8>& models, int n,
                                  std::uint64_t given) {
  const int n_seen = std::min(n, 3);
  std::uint32_t place = 1;
  {
    Held held(coder);
    for (int i = 1; i <= n_seen; ++i)
      place = 2 * place + (held.bit(models[place], (given >> (n - i) & 1) != 0) ? 1 : 0);
  }
  const int n_plain = n - n_seen;
  return std::uint64_t{place} << n_plain | code_plain(coder, n_plain, given);
}

/// A number up to 2^17 - 2, small ones in few bits: of the number and 1, how many bits are behind
/// the highest one, one by one, then these.
class NumberModel {
 public:
  static constexpr std::uint32_t kLargest = (1U << 17) - 2;

  template <typename Coder>
  std::uint32_t code(Coder& coder, std::uint32_t given) {
    const auto n_given = static_cast<std::uint32_t>(std::bit_width(given + 1U) - 1);
    const std::uint32_t n = std::min(n_bits_.code(coder, n_given), kMostBits);
    return static_cast<std::uint32_t>(
        code_behind_highest(coder, behind_[n], static_cast<int>(n), std::uint64_t{given} + 1) - 1);
  }

 private:
  static constexpr std::uint32_t kMostBits = 16;
  SymbolModel<5> n_bits_;
  std::array<std::array<BitModel, 8>, kMostBits + 1> behind_;
};

/// Any number of 64 bits: how many it has from the highest that is 1, then those behind it.
class WideModel {
 public:
  template <typename Coder>
  std::uint64_t code(Coder& coder, std::uint64_t given) {
    const auto n = n_bits_.code(coder, static_cast<std::uint32_t>(std::bit_width(given)));
    if (n == 0) return 0;
    // Where bytes are wrong it may be up to 127.
    const std::uint32_t n_behind = std::min(n - 1, 63U);
    return code_behind_highest(coder, behind_[n_behind], static_cast<int>(n_behind), given);
  }

 private:
  SymbolModel<7> n_bits_;
  std::array<std::array<BitModel, 8>, 64> behind_;
};

/// Counts, mostly below 2^kBits - 1.
template <int kBits>
class CountModel {
 public:
  template <typename Coder>
  std::uint32_t code(Coder& coder, std::uint32_t given) {
    constexpr std::uint32_t kMany = (1U << kBits) - 1;
    const std::uint32_t few = few_.code(coder, std::min(given, kMany));
    return few < kMany ? few : kMany + many_.code(coder, given - kMany);
  }

 private:
  SymbolModel<kBits> few_;
  NumberModel many_;
};

}  // namespace lode::tetra_mt
