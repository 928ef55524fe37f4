#include "lode/io/crc32c.h"

#include <array>

namespace lode::io {
namespace {

/// kCrcTables[k][b]: what byte b changes in the sum when k more bytes follow it.
using CrcTables = std::array<std::array<std::uint32_t, 256>, 8>;

constexpr CrcTables make_crc_tables() {
  constexpr std::uint32_t kReflectedPolynomial = 0x82f63b78;
  CrcTables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t sum = byte;
    for (int bit = 0; bit < 8; ++bit)
      sum = (sum >> 1) ^ ((sum & 1) != 0 ? kReflectedPolynomial : 0);
    tables[0][byte] = sum;
  }
  for (std::size_t k = 1; k < tables.size(); ++k)
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t sum = tables[k - 1][byte];
      tables[k][byte] = (sum >> 8) ^ tables[0][sum & 255];
    }
  return tables;
}

constexpr CrcTables kCrcTables = make_crc_tables();

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes) {
  std::uint32_t sum = 0xffffffff;
  // Eight bytes at a time: their changes do not depend on one another.
  while (bytes.size() >= 8) {
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      auto byte = std::to_integer<std::uint32_t>(bytes[i]);
      if (i < 4) byte ^= (sum >> (8 * i)) & 255;
      next ^= kCrcTables[7 - i][byte];
    }
    sum = next;
    bytes = bytes.subspan(8);
  }
  for (const std::byte byte : bytes)
    sum = (sum >> 8) ^ kCrcTables[0][(sum ^ std::to_integer<std::uint32_t>(byte)) & 255];
  return ~sum;
}

}  // namespace lode::io
