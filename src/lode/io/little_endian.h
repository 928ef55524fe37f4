#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "lode/core/expects.h"

namespace lode::io {

/// Numbers in bytes that begin with the least significant, at offsets that the caller has checked.
class LittleEndian {
 public:
  explicit LittleEndian(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::uint8_t u8(std::size_t at) const { return number<std::uint8_t>(at); }
  [[nodiscard]] std::uint16_t u16(std::size_t at) const { return number<std::uint16_t>(at); }
  [[nodiscard]] std::uint32_t u32(std::size_t at) const { return number<std::uint32_t>(at); }
  [[nodiscard]] std::uint64_t u64(std::size_t at) const { return number<std::uint64_t>(at); }
  [[nodiscard]] std::int32_t i32(std::size_t at) const {
    return static_cast<std::int32_t>(u32(at));
  }
  [[nodiscard]] double f64(std::size_t at) const { return std::bit_cast<double>(u64(at)); }
  /// Up to the first zero.
  [[nodiscard]] std::string text(std::size_t at, std::size_t n) const {
    std::string text;
    for (std::size_t i = at; i < at + n && u8(i) != 0; ++i) text += static_cast<char>(u8(i));
    return text;
  }

 private:
  template <typename T>
  [[nodiscard]] T number(std::size_t at) const {
    LODE_EXPECTS(at + sizeof(T) <= bytes_.size());
    std::uint64_t value = 0;
    for (std::size_t i = sizeof(T); i-- > 0;)
      value = value << 8 | std::to_integer<std::uint64_t>(bytes_[at + i]);
    return static_cast<T>(value);
  }

  std::span<const std::byte> bytes_;
};

}  // namespace lode::io
