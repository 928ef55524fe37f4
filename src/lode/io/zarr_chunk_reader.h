#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/chunk_cache.h"
#include "lode/io/input_file.h"
#include "lode/io/zarr_array.h"
#include "lode/io/zarr_codecs.h"

namespace lode::io {

/// Reads and decodes the chunks of an array, each on its own. Safe on any number of threads.
class ZarrChunkReader {
 public:
  using Bytes = ChunkCache::Bytes;

  explicit ZarrChunkReader(ZarrArray array);

  [[nodiscard]] const ZarrArray& array() const { return array_; }
  /// Counts what is read of chunks.
  [[nodiscard]] const IoTally& tally() const { return *tally_; }
  /// Samples along the axes of a chunk.
  [[nodiscard]] const ZarrShape& chunk_shape() const { return units_.shape; }
  /// The samples of a whole chunk, also where it sticks out of the array: last axis fastest, native
  /// byte order. Null where the chunk is missing: then all are array().fill. Fails, naming the
  /// file, on anything damaged.
  [[nodiscard]] Result<Bytes> read(std::span<const std::int64_t> chunk);
  /// Bytes in files for a byte of samples: the mean of some files here and there, missing ones
  /// included.
  [[nodiscard]] double stored_share() const;

 private:
  [[nodiscard]] Result<Bytes> read_part(const InputFile& file, const std::string& name,
                                        std::uint64_t offset, std::uint64_t n_bytes) const;
  [[nodiscard]] Result<Bytes> read_from_shard(const InputFile& file,
                                              std::span<const std::int64_t> shard,
                                              std::span<const std::int64_t> chunk);
  [[nodiscard]] Result<Bytes> index_of(const InputFile& file, std::int64_t shard_number);

  ZarrArray array_;
  ZarrUnits units_;
  ZarrChunkForm form_;
  ChunkCache indexes_;  ///< Of shards.
  IoTallyPtr tally_ = std::make_shared<IoTally>();
};

}  // namespace lode::io
