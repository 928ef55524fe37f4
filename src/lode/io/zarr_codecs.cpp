#include "lode/io/zarr_codecs.h"

#include <algorithm>
#include <cstring>

#include "lode/io/image.h"
#include "lode/io/zarr_decompress.h"
#include "lode/io/zarr_shard.h"

namespace lode::io {
namespace {

/// Sorts samples so that the array's last axis is fastest: `stored` has axis order[i] at place i.
template <typename T>
void restore_axis_order(const ZarrShape& shape, std::span<const std::size_t> order,
                        const std::byte* stored, std::byte* out) {
  const std::size_t rank = shape.size();
  ZarrShape strides(rank);
  std::int64_t stride = 1;
  for (std::size_t place = rank; place > 0; --place) {
    strides[order[place - 1]] = stride;
    stride *= shape[order[place - 1]];
  }
  const std::int64_t row = shape[rank - 1];
  const std::int64_t step = strides[rank - 1];
  ZarrShape index(rank, 0);
  for (std::int64_t n_rows = stride / row; n_rows > 0; --n_rows) {
    std::int64_t first = 0;
    for (std::size_t axis = 0; axis + 1 < rank; ++axis) first += index[axis] * strides[axis];
    for (std::int64_t i = 0; i < row; ++i, out += sizeof(T))
      std::memcpy(out, stored + static_cast<std::size_t>(first + i * step) * sizeof(T), sizeof(T));
    for (std::size_t axis = rank - 1; axis > 0 && ++index[axis - 1] == shape[axis - 1]; --axis)
      index[axis - 1] = 0;
  }
}

std::uint64_t n_chunks_of(const ZarrShard& shard, const ZarrChunkForm& form) {
  return static_cast<std::uint64_t>(product_of(form.shape) / product_of(shard.chunk_shape));
}

/// The form of a chunk as it is stored, before its axes were put in another order.
ZarrChunkForm stored_form(const ZarrCodecs& codecs, const ZarrChunkForm& form) {
  ZarrChunkForm stored = form;
  for (std::size_t place = 0; place < codecs.order.size(); ++place)
    stored.shape[place] = form.shape[codecs.order[place]];
  return stored;
}

Result<std::vector<std::byte>> decode_samples(const std::string& name, const ZarrCodecs& codecs,
                                              const ZarrChunkForm& form,
                                              std::span<const std::byte> stored) {
  if (codecs.shard != nullptr) {
    // No compressor is round a shard, only checksums.
    for (std::size_t i = 0; i < codecs.bytes_codecs.size(); ++i) {
      LODE_TRY(stored, without_checksum(name, stored));
    }
    return decode_shard(name, *codecs.shard, stored_form(codecs, form), stored);
  }
  std::vector<std::byte> samples(static_cast<std::size_t>(form.n_bytes()));
  LODE_CHECK(decode_bytes(name, codecs.bytes_codecs, stored, samples));
  to_native(samples, form.type, codecs.byte_order);
  return samples;
}

}  // namespace

std::uint64_t ZarrChunkForm::n_bytes() const {
  return static_cast<std::uint64_t>(product_of(shape)) * size_of(type);
}

Result<void> check_stored_size(const std::string& name, const ZarrCodecs& codecs,
                               const ZarrChunkForm& form, std::uint64_t n_stored) {
  const std::uint64_t n_bytes = form.n_bytes();
  std::uint64_t n_checksum_bytes = 0;
  bool is_compressed = false;
  for (const ZarrBytesCodec codec : codecs.bytes_codecs) {
    if (codec == ZarrBytesCodec::crc32c) {
      n_checksum_bytes += kChecksumBytes;
      continue;
    }
    is_compressed = true;
    if (max_decoded_bytes(codec, n_stored) < n_bytes)
      return fail("{}: expected a chunk of {} bytes, more than {} compressed bytes can hold", name,
                  n_bytes, n_stored);
  }
  const bool has_known_size = !is_compressed && codecs.shard == nullptr;
  if (has_known_size && n_stored != n_bytes + n_checksum_bytes)
    return fail("{}: expected {} bytes, got {}", name, n_bytes + n_checksum_bytes, n_stored);
  // Incompressible data grow by less than a tenth in all of these formats.
  constexpr std::uint64_t kHeaders = 1 << 16;
  std::uint64_t n_most = n_bytes + n_bytes / 8 + n_checksum_bytes + kHeaders;
  // A small chunk in a shard has an index entry and a header of its own.
  if (codecs.shard != nullptr) n_most += 64 * n_chunks_of(*codecs.shard, form);
  if (n_stored > n_most)
    return fail("{}: expected at most {} bytes for a chunk of {}, got {}", name, n_most, n_bytes,
                n_stored);
  return {};
}

Result<std::vector<std::byte>> decode_chunk(const std::string& name, const ZarrCodecs& codecs,
                                            const ZarrChunkForm& form,
                                            std::span<const std::byte> stored) {
  LODE_CHECK(check_stored_size(name, codecs, form, stored.size()));
  LODE_TRY(std::vector<std::byte> samples, decode_samples(name, codecs, form, stored));
  if (codecs.order.empty()) return samples;
  std::vector<std::byte> sorted(samples.size());
  visit_scalar_type(form.type, [&]<typename T>() {
    restore_axis_order<T>(form.shape, codecs.order, samples.data(), sorted.data());
  });
  return sorted;
}

}  // namespace lode::io
