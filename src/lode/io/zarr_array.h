#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/scalar_type.h"
#include "lode/io/volume_reader.h"

namespace lode::io {

/// Time, channel, z, y, x.
inline constexpr std::size_t kMaxZarrRank = 5;
/// Decoded, of a chunk that is decoded as a whole: what the usual compressors can take.
inline constexpr std::uint64_t kMaxZarrChunkBytes = (std::uint64_t{1} << 31) - 1;

/// Counts along the axes of an array; the last one is x and varies fastest in memory.
using ZarrShape = std::vector<std::int64_t>;

/// A codec that makes bytes from bytes.
enum class ZarrBytesCodec { gzip, zlib, zstd, blosc, crc32c };

struct ZarrShard;

/// How a chunk's samples became the bytes of a file. At most one of the bytes_codecs compresses,
/// and none does where there is a shard: so all sizes but the compressed one are known.
struct ZarrCodecs {
  /// Axis i of the stored chunk is axis order[i] of the array; empty: they are the same.
  std::vector<std::size_t> order;
  ByteOrder byte_order = ByteOrder::little;
  std::shared_ptr<const ZarrShard> shard;    ///< Null: the samples themselves are stored.
  std::vector<ZarrBytesCodec> bytes_codecs;  ///< In the order of encoding.
};

enum class ZarrIndexPlace { start, end };

/// A chunk that is made of smaller ones, with an index of where they are.
struct ZarrShard {
  ZarrShape chunk_shape;  ///< Divides the shard's shape.
  ZarrCodecs codecs;      ///< Of the inner chunks.
  ZarrIndexPlace index_place = ZarrIndexPlace::end;
  ByteOrder index_byte_order = ByteOrder::little;
  std::size_t n_index_checksums = 0;
};

/// One sample in native byte order; the rest is 0.
using ZarrFill = std::array<std::byte, 8>;

/// A Zarr array in a directory, as its metadata say it and after they were checked: all counts are
/// at least 1, and no product of sizes overflows.
struct ZarrArray {
  std::string path;  ///< Of the directory.
  int version = 2;   ///< 2 or 3.
  ZarrShape shape;   ///< 2 to kMaxZarrRank axes.
  ZarrShape chunk_shape;
  ScalarType type = ScalarType::uint8;
  ZarrFill fill{};  ///< Of samples in chunks that are missing.
  ZarrCodecs codecs;
  std::string key_prefix;  ///< Of chunk names, "c/" or empty.
  char key_separator = '.';
  std::vector<std::string> dimension_names;  ///< One an axis, empty where unnamed; or none at all.
};

/// The chunks that can be decoded each on its own: those inside shards where that is possible.
struct ZarrUnits {
  ZarrShape shape;
  ZarrShape per_file;  ///< Along each axis; 1 where the files are not shards.
  const ZarrCodecs* codecs = nullptr;
};
[[nodiscard]] ZarrUnits units_of(const ZarrArray& array);

enum class ZarrNode { none, array, group };

/// What the metadata in `directory` say it is; none where there are none. Fails, naming the file,
/// when they cannot be read.
[[nodiscard]] Result<ZarrNode> zarr_node_at(const std::string& directory);
/// Reads zarr.json or else .zarray. Fails, naming the file, on anything missing, unknown or out of
/// bounds.
[[nodiscard]] Result<ZarrArray> read_zarr_array(const std::string& directory);

/// The file of a chunk (or shard), whether it is there or not.
[[nodiscard]] std::string chunk_path(const ZarrArray& array, std::span<const std::int64_t> chunk);

/// The product of all; they are known not to overflow.
[[nodiscard]] std::int64_t product_of(std::span<const std::int64_t> counts);

/// "raw", "blosc", "shards of zstd", ...
[[nodiscard]] std::string describe_codecs(const ZarrCodecs& codecs);

}  // namespace lode::io
