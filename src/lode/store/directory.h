#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/store/format.h"

namespace lode::store {

/// What a file holds.
struct Directory {
  std::string model;
  std::vector<std::byte> metadata;  ///< The model's own.
  std::vector<BlockEntry> blocks;   ///< In the order of the file.
};

/// Uncompressed; offsets are not written, for they follow from the sizes.
[[nodiscard]] std::vector<std::byte> encode_directory(const Directory& directory);

/// Where the bytes come from, and what bounds them.
struct DirectoryContext {
  std::string path;
  std::uint64_t blocks_begin = kHeaderBytes;
  std::uint64_t blocks_end = 0;    ///< Where the last block must end: the directory's offset.
  std::uint64_t memory_limit = 0;  ///< For the decoded directory, bytes.
};

/// Memory that a decoded entry takes, with its place in an order.
inline constexpr std::uint64_t kEntryMemory = sizeof(BlockEntry) + sizeof(std::size_t);

/// Decodes uncompressed bytes. The blocks that come back have known codecs,
/// plausible raw sizes, and fill the file from `blocks_begin` to `blocks_end` exactly.
[[nodiscard]] Result<Directory> decode_directory(std::span<const std::byte> bytes,
                                                 const DirectoryContext& context);
/// The same of blocks back to back from `blocks_begin` that end anywhere up to `blocks_end`.
[[nodiscard]] Result<Directory> decode_run(std::span<const std::byte> bytes,
                                           const DirectoryContext& context);

/// Where the last of a directory's blocks ends; kHeaderBytes without any.
[[nodiscard]] std::uint64_t end_of(std::span<const BlockEntry> blocks);

/// Indices of `blocks` in ascending order of their keys, of equal ones in that of the file.
[[nodiscard]] std::vector<std::size_t> order_by_key(std::span<const BlockEntry> blocks);

/// Fails when two blocks, in the order that order_by_key gave, have the same key.
[[nodiscard]] Result<void> check_keys_differ(std::span<const BlockEntry> blocks,
                                             std::span<const std::size_t> order,
                                             const std::string& path);

}  // namespace lode::store
