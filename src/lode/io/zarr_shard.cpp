#include "lode/io/zarr_shard.h"

#include <cstring>
#include <limits>

#include "lode/io/image.h"
#include "lode/io/zarr_decompress.h"

namespace lode::io {
namespace {

/// Offset and length, both 64 bits.
constexpr std::uint64_t kEntryBytes = 16;
constexpr std::uint64_t kMissing = std::numeric_limits<std::uint64_t>::max();

/// The chunk at a place of its shard, as samples go out there: row by row.
class ShardWriter {
 public:
  ShardWriter(const ZarrChunkForm& form, const ZarrShape& chunk_shape, std::span<std::byte> out)
      : form_(form), chunk_shape_(chunk_shape), out_(out) {}

  /// `samples` empty: the fill value.
  void put(std::span<const std::int64_t> chunk, std::span<const std::byte> samples) {
    const std::size_t rank = chunk_shape_.size();
    const std::size_t row_bytes =
        static_cast<std::size_t>(chunk_shape_.back()) * size_of(form_.type);
    const std::int64_t n_rows = product_of(chunk_shape_) / chunk_shape_.back();
    ZarrShape index(rank, 0);
    for (std::int64_t row = 0; row < n_rows; ++row) {
      std::int64_t first = 0;
      for (std::size_t axis = 0; axis < rank; ++axis)
        first = first * form_.shape[axis] + chunk[axis] * chunk_shape_[axis] + index[axis];
      const auto to =
          out_.subspan(static_cast<std::size_t>(first) * size_of(form_.type), row_bytes);
      if (samples.empty())
        fill(to);
      else
        std::memcpy(to.data(), samples.data() + static_cast<std::size_t>(row) * row_bytes,
                    row_bytes);
      for (std::size_t axis = rank - 1; axis > 0 && ++index[axis - 1] == chunk_shape_[axis - 1];
           --axis)
        index[axis - 1] = 0;
    }
  }

 private:
  void fill(std::span<std::byte> row) const {
    const std::size_t size = size_of(form_.type);
    for (std::size_t i = 0; i < row.size(); i += size)
      std::memcpy(row.data() + i, form_.fill.data(), size);
  }

  const ZarrChunkForm& form_;
  const ZarrShape& chunk_shape_;
  std::span<std::byte> out_;
};

/// The next place with the last axis fastest.
void advance(ZarrShape& place, const ZarrShape& counts) {
  for (std::size_t axis = place.size(); axis > 0 && ++place[axis - 1] == counts[axis - 1]; --axis)
    place[axis - 1] = 0;
}

}  // namespace

Result<ByteRange> shard_index_range(const std::string& name, const ZarrShard& shard,
                                    std::uint64_t n_chunks, std::uint64_t n_stored) {
  const std::uint64_t n_bytes =
      n_chunks * kEntryBytes + std::uint64_t{kChecksumBytes} * shard.n_index_checksums;
  if (n_stored < n_bytes)
    return fail("{}: expected an index of {} bytes for {} chunks, the shard has {} bytes", name,
                n_bytes, n_chunks, n_stored);
  return ByteRange{shard.index_place == ZarrIndexPlace::start ? 0 : n_stored - n_bytes, n_bytes};
}

Result<std::span<const std::byte>> shard_index_entries(const std::string& name,
                                                       const ZarrShard& shard,
                                                       std::span<const std::byte> index) {
  for (std::size_t i = 0; i < shard.n_index_checksums; ++i) {
    LODE_TRY(index, without_checksum(name + ", its index", index));
  }
  return index;
}

Result<std::optional<ByteRange>> find_in_shard(const std::string& name, const ZarrShard& shard,
                                               std::span<const std::byte> entries,
                                               std::uint64_t number, std::uint64_t n_stored) {
  std::array<std::uint64_t, 2> entry{};
  const std::span<std::byte> bytes = std::as_writable_bytes(std::span(entry));
  std::memcpy(bytes.data(), entries.data() + number * kEntryBytes, kEntryBytes);
  to_native(bytes, ScalarType::uint64, shard.index_byte_order);
  const auto [offset, n_bytes] = entry;
  if (offset == kMissing && n_bytes == kMissing) return std::optional<ByteRange>{};
  if (offset > n_stored || n_bytes > n_stored - offset)
    return fail("{}: expected chunk {} inside the {} bytes of its shard, got {} bytes from {}",
                name, number, n_stored, n_bytes, offset);
  return std::optional(ByteRange{offset, n_bytes});
}

std::string name_in_shard(const std::string& name, std::span<const std::int64_t> chunk) {
  return fmt::format("{}, chunk {} in it", name, fmt::join(chunk, "/"));
}

Result<std::vector<std::byte>> decode_shard(const std::string& name, const ZarrShard& shard,
                                            const ZarrChunkForm& form,
                                            std::span<const std::byte> stored) {
  ZarrShape counts;
  for (std::size_t axis = 0; axis < form.shape.size(); ++axis)
    counts.push_back(form.shape[axis] / shard.chunk_shape[axis]);
  const auto n_chunks = static_cast<std::uint64_t>(product_of(counts));
  LODE_TRY(const ByteRange range, shard_index_range(name, shard, n_chunks, stored.size()));
  LODE_TRY(const auto entries,
           shard_index_entries(name, shard, stored.subspan(range.offset, range.n_bytes)));
  const ZarrChunkForm chunk_form{shard.chunk_shape, form.type, form.fill};
  std::vector<std::byte> samples(static_cast<std::size_t>(form.n_bytes()));
  ShardWriter writer(form, shard.chunk_shape, samples);
  ZarrShape chunk(counts.size(), 0);
  for (std::uint64_t i = 0; i < n_chunks; ++i, advance(chunk, counts)) {
    LODE_TRY(const auto part, find_in_shard(name, shard, entries, i, stored.size()));
    std::vector<std::byte> decoded;
    if (part) {
      LODE_TRY(decoded, decode_chunk(name_in_shard(name, chunk), shard.codecs, chunk_form,
                                     stored.subspan(part->offset, part->n_bytes)));
    }
    writer.put(chunk, decoded);
  }
  return samples;
}

}  // namespace lode::io
