#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/zarr_array.h"
#include "lode/io/zarr_codecs.h"

namespace lode::io {

/// A part of a file or of bytes in memory.
struct ByteRange {
  std::uint64_t offset = 0;
  std::uint64_t n_bytes = 0;
};

/// Where the index of a shard of `n_stored` bytes and `n_chunks` chunks lies. Fails, naming the
/// shard, when it is too short to have one.
[[nodiscard]] Result<ByteRange> shard_index_range(const std::string& name, const ZarrShard& shard,
                                                  std::uint64_t n_chunks, std::uint64_t n_stored);

/// The entries of an index that was read as stored, once its checksums were found to agree.
[[nodiscard]] Result<std::span<const std::byte>> shard_index_entries(
    const std::string& name, const ZarrShard& shard, std::span<const std::byte> index);

/// Where chunk `number` (last axis fastest) lies; nothing where it is missing. Fails, naming the
/// shard, when that is outside of its `n_stored` bytes.
[[nodiscard]] Result<std::optional<ByteRange>> find_in_shard(const std::string& name,
                                                             const ZarrShard& shard,
                                                             std::span<const std::byte> entries,
                                                             std::uint64_t number,
                                                             std::uint64_t n_stored);

/// What a chunk of a shard is called in messages.
[[nodiscard]] std::string name_in_shard(const std::string& name,
                                        std::span<const std::int64_t> chunk);

/// All samples of a shard in memory, as decode_chunk gives those of a chunk.
[[nodiscard]] Result<std::vector<std::byte>> decode_shard(const std::string& name,
                                                          const ZarrShard& shard,
                                                          const ZarrChunkForm& form,
                                                          std::span<const std::byte> stored);

}  // namespace lode::io
