#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/result.h"
#include "lode/store/format.h"

namespace lode::store {

/// A block ready to be written.
struct EncodedBlock {
  Codec codec = Codec::none;
  std::uint8_t element_size = 1;
  std::uint64_t raw_size = 0;
  std::vector<std::byte> stored;
};

/// Compresses raw bytes that are little-endian numbers of element_size (1, 2, 4 or 8) bytes, with
/// whichever codec does best on a sample. At most kMaxBlockBytes in, never more bytes out than
/// in. Safe from many threads; the result depends on the arguments alone.
[[nodiscard]] EncodedBlock encode_block(std::span<const std::byte> raw, std::size_t element_size);

/// The same with a codec of the caller's choice; Codec::none where that would be no longer.
[[nodiscard]] EncodedBlock encode_block_as(Codec codec, std::span<const std::byte> raw,
                                           std::size_t element_size);

/// Fills exactly `out`; fails, without saying where, when the stored bytes do not decode to that
/// many. Safe from many threads.
[[nodiscard]] Result<void> decode_block(Codec codec, std::size_t element_size,
                                        std::span<const std::byte> stored,
                                        std::span<std::byte> out);

/// One zstd frame with its content size, as the codecs and the directory use it.
[[nodiscard]] std::vector<std::byte> zstd_compress(std::span<const std::byte> raw);
[[nodiscard]] Result<void> zstd_decompress(std::span<const std::byte> stored,
                                           std::span<std::byte> out);

}  // namespace lode::store
