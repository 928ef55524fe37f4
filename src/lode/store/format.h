#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/vec.h"

/// The numbers of the .lode container; docs/format.md says what they mean.
namespace lode::store {

inline constexpr std::size_t kMagicBytes = 8;
/// A byte above 127 catches 7-bit transfers, CR LF and LF catch line-end conversion, 0x1A stops
/// a DOS `type`.
inline constexpr std::array<unsigned char, kMagicBytes> kMagic = {0x8B, 'L',  'O',  'D',
                                                                  0x0D, 0x0A, 0x1A, 0x0A};
inline constexpr std::uint32_t kFormatVersion = 2;
/// Must-understand features: that blocks may have Codec::predicted_zstd or ranked_zstd;
inline constexpr std::uint64_t kFeaturePredicted = 1;
/// that errors of nodes with removed cells are infinite, also of those that have no others;
inline constexpr std::uint64_t kFeatureRemovedCells = 2;
/// that metadata of a model end with units.
inline constexpr std::uint64_t kFeatureUnits = 4;
inline constexpr std::uint64_t kKnownFeatures =
    kFeaturePredicted | kFeatureRemovedCells | kFeatureUnits;
inline constexpr std::size_t kHeaderBytes = 128;

/// No block is larger than this when decoded; 64 KiB to 1 MiB is usual. A constant, because
/// constant data compresses thousands of times and so the stored size bounds nothing.
inline constexpr std::uint64_t kMaxBlockBytes = std::uint64_t{64} << 20;
/// zstd cannot do better: 4 stored bytes (a block header and a repeated byte) yield at most
/// 128 KiB. A larger raw size is a lie that costs no memory to detect.
inline constexpr std::uint64_t kMaxZstdRatio = 32768;

/// How the stored bytes of a block become its raw bytes.
enum class Codec : std::uint8_t {
  none = 0,            ///< As they are.
  zstd = 1,            ///< One zstd frame.
  shuffle_zstd = 2,    ///< Byte planes of the elements, then zstd.
  delta_zstd = 3,      ///< Differences of consecutive elements, zigzag, byte planes, then zstd.
  predicted_zstd = 4,  ///< Differences from neighbours on a grid, then likewise; grid_filter.h.
  ranked_zstd = 5,     ///< Few values, then which of them by predicted_zstd; rank_filter.h.
};
inline constexpr std::uint8_t kLastCodec = 5;

/// Whether blocks may be made of elements of that many bytes.
[[nodiscard]] constexpr bool is_element_size(std::uint64_t size) {
  return size == 1 || size == 2 || size == 4 || size == 8;
}

/// What a block holds, in the model's own words; unique in a file.
struct BlockKey {
  std::uint32_t kind = 0;
  std::uint32_t level = 0;
  Index3 position;

  friend constexpr bool operator==(const BlockKey&, const BlockKey&) = default;
  friend constexpr auto operator<=>(const BlockKey&, const BlockKey&) = default;
};

/// Kind of the blocks that say which blocks follow them (block_index.h): positions count them from
/// 0 along x. A model's own kinds begin with 1.
inline constexpr std::uint32_t kIndexKind = 0;
[[nodiscard]] constexpr bool is_index(const BlockKey& key) { return key.kind == kIndexKind; }

/// Where a block lies and how to check and decode it.
struct BlockEntry {
  BlockKey key;
  std::uint64_t offset = 0;       ///< Of the first stored byte, from the start of the file.
  std::uint64_t stored_size = 0;  ///< At most raw_size, and just that without compression.
  std::uint64_t raw_size = 0;     ///< At most kMaxBlockBytes.
  std::uint64_t checksum = 0;     ///< Of the stored bytes.
  Codec codec = Codec::none;
  std::uint8_t element_size = 1;  ///< 1, 2, 4 or 8.

  friend constexpr bool operator==(const BlockEntry&, const BlockEntry&) = default;
};

/// "block (kind 1, level 2, position 3 4 5)", for messages.
[[nodiscard]] std::string describe(const BlockKey& key);

}  // namespace lode::store
