#pragma once

// Numbers in the raw bytes of blocks, as the codecs take them: unsigned, modulo 2^bits.

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace lode::store {

template <typename T>
T load_element(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

template <typename T>
void store_element(std::byte* to, T value) {
  std::memcpy(to, &value, sizeof(T));
}

/// Calls f with an unsigned zero of the element size.
template <typename F>
decltype(auto) visit_element(std::size_t element_size, F&& f) {
  switch (element_size) {
    case 1: return f(std::uint8_t{0});
    case 2: return f(std::uint16_t{0});
    case 4: return f(std::uint32_t{0});
    default: return f(std::uint64_t{0});
  }
}

// Differences are modulo 2^bits, so they are exact for floating-point patterns too. Zigzag maps
// 0, -1, 1, -2 ... to 0, 1, 2, 3 ...: small differences of either sign have zero high bytes.
template <typename T>
T zigzag(T difference) {
  const T sign = static_cast<T>(0 - (difference >> (8 * sizeof(T) - 1)));
  return static_cast<T>(static_cast<T>(difference << 1) ^ sign);
}

template <typename T>
T unzigzag(T code) {
  return static_cast<T>(static_cast<T>(code >> 1) ^ static_cast<T>(0 - (code & 1)));
}

}  // namespace lode::store
