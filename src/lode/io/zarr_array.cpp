#include "lode/io/zarr_array.h"

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "lode/io/image.h"
#include "lode/io/text.h"
#include "lode/io/zarr_json.h"
#include "lode/io/zarr_metadata.h"

namespace lode::io {
namespace {

/// Its index of 16 bytes each is held in memory.
constexpr std::uint64_t kMaxChunksInShard = std::uint64_t{1} << 22;

bool exists(const std::string& path) {
  std::error_code ignored;
  const auto type = std::filesystem::symlink_status(path, ignored).type();
  return type != std::filesystem::file_type::not_found && type != std::filesystem::file_type::none;
}

/// Of a shard that is decoded as a whole: a few bytes can stand for any number of missing chunks.
constexpr std::uint64_t kMaxWholeShardBytes = std::uint64_t{256} << 20;

Result<void> check_whole_chunk(const std::string& path, const ZarrShape& shape, ScalarType type,
                               bool is_shard) {
  LODE_TRY(const std::uint64_t n_bytes, checked_n_bytes(path, shape, size_of(type)));
  const std::uint64_t n_most = is_shard ? kMaxWholeShardBytes : kMaxZarrChunkBytes;
  if (n_bytes <= n_most) return {};
  return fail("{}: expected {} of at most {} bytes, got {}", path,
              is_shard ? "shards that are decoded as a whole" : "chunks", n_most, n_bytes);
}

/// Whether single chunks of a shard can be read without decoding the rest of its file.
bool is_open_shard(const ZarrCodecs& codecs) {
  return codecs.shard != nullptr && codecs.order.empty() && codecs.bytes_codecs.empty();
}

Result<void> check_codecs(const std::string& path, const ZarrCodecs& codecs, const ZarrShape& shape,
                          ScalarType type, bool is_file) {
  if (!is_file || !is_open_shard(codecs))
    LODE_CHECK(check_whole_chunk(path, shape, type, codecs.shard != nullptr));
  if (codecs.shard == nullptr) return {};
  const ZarrShape& inner = codecs.shard->chunk_shape;
  if (inner.size() != shape.size())
    return fail("{}: expected chunks in shards of {} axes, got {}", path, shape.size(),
                inner.size());
  ZarrShape counts;
  for (std::size_t stored = 0; stored < shape.size(); ++stored) {
    const std::size_t axis = codecs.order.empty() ? stored : codecs.order[stored];
    if (inner[stored] < 1 || shape[axis] % inner[stored] != 0)
      return fail("{}: expected chunks that divide their shard, got {} in {} along axis {}", path,
                  inner[stored], shape[axis], stored);
    counts.push_back(shape[axis] / inner[stored]);
  }
  LODE_TRY(const std::uint64_t n_chunks, checked_n_bytes(path, counts, 1));
  if (n_chunks > kMaxChunksInShard)
    return fail("{}: expected at most {} chunks in a shard, got {}", path, kMaxChunksInShard,
                n_chunks);
  return check_codecs(path, codecs.shard->codecs, inner, type, false);
}

Result<void> check_array(const std::string& path, const ZarrArray& array) {
  const std::size_t rank = array.shape.size();
  if (rank < 2)
    return fail("{}: expected an array of 2 to {} axes, got {}", path, kMaxZarrRank, rank);
  if (array.chunk_shape.size() != rank)
    return fail("{}: expected chunks of {} axes, got {}", path, rank, array.chunk_shape.size());
  // One less than int32 holds, so that an exclusive upper bound plus one still fits.
  constexpr std::int64_t kMaxCount = std::numeric_limits<std::int32_t>::max() - 1;
  for (std::size_t axis = 0; axis < rank; ++axis)
    for (const std::int64_t count : {array.shape[axis], array.chunk_shape[axis]})
      if (count < 1 || count > kMaxCount)
        return fail("{}: expected 1 to {} samples along axis {} of an array and its chunks, got {}",
                    path, kMaxCount, axis, count);
  if (auto n_bytes = checked_n_bytes(path, array.shape, size_of(array.type)); !n_bytes)
    return n_bytes.error();
  return check_codecs(path, array.codecs, array.chunk_shape, array.type, true);
}

std::string_view name_of(ZarrBytesCodec codec) {
  switch (codec) {
    case ZarrBytesCodec::gzip: return "gzip";
    case ZarrBytesCodec::zlib: return "zlib";
    case ZarrBytesCodec::zstd: return "zstd";
    case ZarrBytesCodec::blosc: return "blosc";
    case ZarrBytesCodec::crc32c: break;
  }
  return "crc32c";
}

}  // namespace

ZarrUnits units_of(const ZarrArray& array) {
  if (!is_open_shard(array.codecs))
    return {array.chunk_shape, ZarrShape(array.shape.size(), 1), &array.codecs};
  const ZarrShard& shard = *array.codecs.shard;
  ZarrUnits units{shard.chunk_shape, {}, &shard.codecs};
  for (std::size_t axis = 0; axis < units.shape.size(); ++axis)
    units.per_file.push_back(array.chunk_shape[axis] / units.shape[axis]);
  return units;
}

Result<ZarrNode> zarr_node_at(const std::string& directory) {
  const std::string path = directory + "/zarr.json";
  if (exists(path)) {
    LODE_TRY(const nlohmann::json metadata, read_json_object(path));
    LODE_TRY(const std::string type, json_text(path, metadata, "node_type"));
    if (type == "array") return ZarrNode::array;
    if (type == "group") return ZarrNode::group;
    return fail("{}: expected a node_type array or group, got {}", path, in_quotes(type));
  }
  if (exists(directory + "/.zarray")) return ZarrNode::array;
  if (exists(directory + "/.zgroup")) return ZarrNode::group;
  return ZarrNode::none;
}

Result<ZarrArray> read_zarr_array(const std::string& directory) {
  const bool is_v3 = exists(directory + "/zarr.json");
  const std::string path = directory + (is_v3 ? "/zarr.json" : "/.zarray");
  if (!exists(path))
    return fail("{}: expected a Zarr array with .zarray or zarr.json, got neither", directory);
  LODE_TRY(const nlohmann::json metadata, read_json_object(path));
  LODE_TRY(ZarrArray array, is_v3 ? parse_zarr_v3(path, metadata) : parse_zarr_v2(path, metadata));
  LODE_CHECK(check_array(path, array));
  array.path = directory;
  return array;
}

std::string chunk_path(const ZarrArray& array, std::span<const std::int64_t> chunk) {
  std::string path = array.path + '/' + array.key_prefix;
  for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
    if (axis > 0) path += array.key_separator;
    path += std::to_string(chunk[axis]);
  }
  return path;
}

std::int64_t product_of(std::span<const std::int64_t> counts) {
  std::int64_t product = 1;
  for (const std::int64_t count : counts) product *= count;
  return product;
}

std::string describe_codecs(const ZarrCodecs& codecs) {
  if (codecs.shard != nullptr) return "shards of " + describe_codecs(codecs.shard->codecs);
  for (const ZarrBytesCodec codec : codecs.bytes_codecs)
    if (codec != ZarrBytesCodec::crc32c) return std::string(name_of(codec));
  return "raw";
}

}  // namespace lode::io
