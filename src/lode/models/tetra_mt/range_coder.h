#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace lode::tetra_mt {

/// How probable it is that a bit is 0, learnt from those that came: in 2^-16, and from how many.
struct BitModel {
  std::uint16_t zero = 1U << 15;
  std::uint16_t n_seen = 0;

  /// Steps get smaller with what was seen: 1 / (n + 1.6), in 2^-16.
  static constexpr std::uint32_t kMostSeen = 60;
  static constexpr auto kRates = [] {
    std::array<std::uint32_t, kMostSeen + 1> rates{};
    for (std::uint32_t n = 0; n <= kMostSeen; ++n) rates[n] = 655360 / (10 * n + 16);
    return rates;
  }();

  /// Neither probability gets below 60 / 65536, as steps are rounded down.
  void learn(bool bit) {
    const std::uint32_t rate = kRates[n_seen];
    const std::uint32_t is_one = 0U - static_cast<std::uint32_t>(bit);  // all bits or none
    const std::uint32_t left = ((65536U - zero) & ~is_one) | (zero & is_one);
    const std::uint32_t step = left * rate >> 16;
    zero = static_cast<std::uint16_t>(zero + ((step ^ is_one) - is_one));
    n_seen = static_cast<std::uint16_t>(n_seen + (n_seen < kMostSeen ? 1 : 0));
  }
};

/// Writes bits in as many bits as they are improbable (range coding: Martin 1979). Calls are those
/// of RangeReader, which return what these are given: so one function says how things are coded
/// both ways.
class RangeWriter {
 public:
  static constexpr bool kReads = false;

  bool bit(BitModel& model, bool given) {
    const std::uint32_t bound = (range_ >> 16) * model.zero;
    if (given) {
      low_ += bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.learn(given);
    normalise();
    return given;
  }
  /// Of n that are equally probable, 1 to 65536.
  std::uint32_t one_of(std::uint32_t n, std::uint32_t given) {
    range_ /= n;
    low_ += std::uint64_t{range_} * given;
    normalise();
    return given;
  }
  /// All that was written: no more than what tells it from anything else.
  [[nodiscard]] std::vector<std::byte> take() &&;

 private:
  void normalise() {
    while (range_ < 1U << 24) {
      push_byte();
      range_ <<= 8;
    }
  }
  void push_byte();

  std::vector<std::byte> bytes_;
  std::uint64_t low_ = 0;  ///< With the carry in bit 32.
  std::uint32_t range_ = 0xFFFFFFFF;
};

/// Reads what RangeWriter wrote. Any bytes are read as something; behind the last one are zeros.
class RangeReader {
 public:
  static constexpr bool kReads = true;

  /// `bytes` must outlive it.
  explicit RangeReader(std::span<const std::byte> bytes);

  [[gnu::always_inline]] bool bit(BitModel& model, bool /*given*/ = false) {
    const std::uint32_t bound = (range_ >> 16) * model.zero;
    const bool found = code_ >= bound;
    // Without branches: which way they go is just what is not known.
    const std::uint32_t is_one = 0U - static_cast<std::uint32_t>(found);
    code_ -= bound & is_one;
    range_ = bound + ((range_ - 2 * bound) & is_one);
    model.learn(found);
    normalise();
    return found;
  }
  std::uint32_t one_of(std::uint32_t n, std::uint32_t /*given*/ = 0) {
    range_ /= n;
    const std::uint32_t found = code_ / range_ < n ? code_ / range_ : n - 1;
    code_ -= range_ * found;
    normalise();
    return found;
  }
  /// Whether as many bytes were there as a writer makes of what was read.
  [[nodiscard]] bool is_at_end() const {
    return n_read_ >= bytes_.size() && n_read_ - bytes_.size() <= sizeof code_;
  }

 private:
  void normalise() {
    while (range_ < 1U << 24) {
      code_ = code_ << 8 | next_byte();
      range_ <<= 8;
    }
  }
  std::uint32_t next_byte() {
    const std::size_t at = n_read_++;
    return at < bytes_.size() ? static_cast<std::uint32_t>(bytes_[at]) : 0;
  }

  std::span<const std::byte> bytes_;
  std::size_t n_read_ = 0;  ///< With zeros behind the end.
  std::uint32_t code_ = 0;
  std::uint32_t range_ = 0xFFFFFFFF;
};

/// A reader's own copy for a loop, whose state can stay in registers; a writer itself.
template <typename Coder>
class Held {
 public:
  explicit Held(Coder& coder) : coder_(coder), held_(coder) {}
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  ~Held() {
    if constexpr (Coder::kReads) coder_ = held_;
  }
  [[gnu::always_inline]] bool bit(BitModel& model, bool given) { return held_.bit(model, given); }

 private:
  Coder& coder_;
  std::conditional_t<Coder::kReads, Coder, Coder&> held_;
};

}  // namespace lode::tetra_mt
