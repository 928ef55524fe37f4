#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/result.h"
#include "lode/store/format.h"
#include "lode/store/grid_filter.h"

namespace lode::store {

/// The raw bytes of a block: little-endian numbers of `size` (1, 2, 4 or 8) bytes.
struct BlockElements {
  std::span<const std::byte> raw;
  std::size_t size = 1;
  std::optional<ElementGrid> grid{};  ///< Where it is known, of as many points as raw has.
};

/// A block ready to be written.
struct EncodedBlock {
  Codec codec = Codec::none;
  std::uint8_t element_size = 1;
  std::uint64_t raw_size = 0;
  std::vector<std::byte> stored;
};

/// Compresses raw bytes with whichever codec does best on a part of them. At most kMaxBlockBytes
/// in, never more bytes out than in. Safe from many threads; the result depends on the arguments
/// alone.
[[nodiscard]] EncodedBlock encode_block(const BlockElements& block);

/// The same with a codec of the caller's choice; Codec::none where that would be no longer.
/// Codec::predicted_zstd and ranked_zstd need the grid; instead of the latter it is the former
/// where too many values differ.
[[nodiscard]] EncodedBlock encode_block_as(Codec codec, const BlockElements& block);

/// Fills exactly `out`; fails, without saying where, when the stored bytes do not decode to that
/// many. Safe from many threads.
[[nodiscard]] Result<void> decode_block(Codec codec, std::size_t element_size,
                                        std::span<const std::byte> stored,
                                        std::span<std::byte> out);

/// One zstd frame with its content size, as the codecs and the directory use it.
[[nodiscard]] std::vector<std::byte> zstd_compress(std::span<const std::byte> raw);
[[nodiscard]] Result<void> zstd_decompress(std::span<const std::byte> stored,
                                           std::span<std::byte> out);
/// The first bytes that a frame of `raw_size` decodes to, of its first stored ones: how many of
/// `out` these give, which may be none. Nothing checks them.
[[nodiscard]] Result<std::size_t> zstd_decompress_start(std::span<const std::byte> stored,
                                                        std::uint64_t raw_size,
                                                        std::span<std::byte> out);

}  // namespace lode::store
