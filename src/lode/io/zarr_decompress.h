#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "lode/core/result.h"
#include "lode/io/zarr_array.h"

namespace lode::io {

/// Undoes `codecs`, the last one first, into `out`. Fails, naming the chunk `name`, unless that
/// gives exactly out.size() bytes and all checksums agree. Safe on any thread.
[[nodiscard]] Result<void> decode_bytes(const std::string& name,
                                        std::span<const ZarrBytesCodec> codecs,
                                        std::span<const std::byte> stored,
                                        std::span<std::byte> out);

/// The most bytes that `n_stored` can be decoded to by a codec; crc32c takes 4 away.
[[nodiscard]] std::uint64_t max_decoded_bytes(ZarrBytesCodec codec, std::uint64_t n_stored);

inline constexpr std::size_t kChecksumBytes = 4;

/// `stored` without the CRC-32C at its end; fails where that is not the sum of the rest.
[[nodiscard]] Result<std::span<const std::byte>> without_checksum(
    const std::string& name, std::span<const std::byte> stored);

}  // namespace lode::io
