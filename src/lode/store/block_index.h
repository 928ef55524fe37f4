#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/store/format.h"

namespace lode::store {

/// What a block of kIndexKind begins with, so that it is found without a directory: no text, and
/// nothing that compression is likely to make.
inline constexpr std::array<unsigned char, 16> kIndexMark = {
    0x8B, 'L', 'O', 'D', 'I', 'N', 'D', 'E', 'X', 0xD3, 0x7E, 0x51, 0xA9, 0x1C, 0xF6, 0x08};
/// Bytes before an index's zstd frame, which holds what a directory does, of the blocks that
/// follow.
inline constexpr std::size_t kIndexHeadBytes = 56;

/// What an index says of itself, without the mark.
struct IndexHead {
  std::uint64_t offset = 0;       ///< Its own, from the start of the file.
  std::uint64_t stored_size = 0;  ///< Of the frame.
  std::uint64_t raw_size = 0;     ///< Of the frame once decompressed.
  std::uint64_t checksum = 0;     ///< Of the stored frame.

  friend constexpr bool operator==(const IndexHead&, const IndexHead&) = default;
};

/// The index that lies at `offset`. run: what encode_directory() makes of the blocks that follow it
/// back to back.
[[nodiscard]] std::vector<std::byte> encode_index(std::span<const std::byte> run,
                                                  std::uint64_t offset);

/// Nothing unless `bytes`, kIndexHeadBytes of them, are a whole head.
[[nodiscard]] std::optional<IndexHead> decode_index_head(std::span<const std::byte> bytes);

}  // namespace lode::store
