#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace lode::io {

/// The CRC of RFC 3720 (Castagnoli's polynomial, reflected, inverted at both ends).
[[nodiscard]] std::uint32_t crc32c(std::span<const std::byte> bytes);

}  // namespace lode::io
