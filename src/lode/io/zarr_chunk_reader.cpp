#include "lode/io/zarr_chunk_reader.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>

#include "lode/io/input_file.h"
#include "lode/io/zarr_shard.h"

namespace lode::io {
namespace {

/// The largest one that a shard may have, or many of the usual ones.
constexpr std::size_t kMaxIndexBytes = std::size_t{64} << 20;
/// Enough to tell whether an array is compressed, and about how well.
constexpr std::int64_t kMaxFilesLookedAt = 32;

/// Nothing at all has that name. Whatever has and is no file is for InputFile to complain of.
bool is_missing(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) != 0 && errno == ENOENT;
}

double size_or_none(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 ? static_cast<double>(status.st_size) : 0;
}

}  // namespace

ZarrChunkReader::ZarrChunkReader(ZarrArray array)
    : array_(std::move(array)),
      units_(units_of(array_)),
      form_{units_.shape, array_.type, array_.fill},
      indexes_(kMaxIndexBytes) {}

Result<ZarrChunkReader::Bytes> ZarrChunkReader::read_part(const InputFile& file,
                                                          const std::string& name,
                                                          std::uint64_t offset,
                                                          std::uint64_t n_bytes) const {
  LODE_CHECK(check_stored_size(name, *units_.codecs, form_, n_bytes));
  std::vector<std::byte> stored(static_cast<std::size_t>(n_bytes));
  LODE_CHECK(file.read(offset, stored));
  LODE_TRY(std::vector<std::byte> samples, decode_chunk(name, *units_.codecs, form_, stored));
  return std::make_shared<const std::vector<std::byte>>(std::move(samples));
}

/// The entries of a shard's index.
Result<ZarrChunkReader::Bytes> ZarrChunkReader::index_of(const InputFile& file,
                                                         std::int64_t shard_number) {
  Bytes held = indexes_.find(shard_number);
  if (held != nullptr) return held;
  const ZarrShard& shard = *array_.codecs.shard;
  const auto n_chunks = static_cast<std::uint64_t>(product_of(units_.per_file));
  LODE_TRY(const ByteRange range, shard_index_range(file.path(), shard, n_chunks, file.size()));
  std::vector<std::byte> stored(static_cast<std::size_t>(range.n_bytes));
  LODE_CHECK(file.read(range.offset, stored));
  LODE_TRY(const auto entries, shard_index_entries(file.path(), shard, stored));
  stored.resize(entries.size());
  held = std::make_shared<const std::vector<std::byte>>(std::move(stored));
  indexes_.begin_read();  // any other one may go
  indexes_.add(shard_number, held);
  return held;
}

Result<ZarrChunkReader::Bytes> ZarrChunkReader::read_from_shard(
    const InputFile& file, std::span<const std::int64_t> shard,
    std::span<const std::int64_t> chunk) {
  std::int64_t shard_number = 0;
  std::int64_t number = 0;
  for (std::size_t axis = 0; axis < shard.size(); ++axis) {
    const std::int64_t n_shards = (array_.shape[axis] - 1) / array_.chunk_shape[axis] + 1;
    shard_number = shard_number * n_shards + shard[axis];
    number = number * units_.per_file[axis] + chunk[axis];
  }
  LODE_TRY(const Bytes entries, index_of(file, shard_number));
  LODE_TRY(const auto part, find_in_shard(file.path(), *array_.codecs.shard, *entries,
                                          static_cast<std::uint64_t>(number), file.size()));
  if (!part) return Bytes{};
  return read_part(file, name_in_shard(file.path(), chunk), part->offset, part->n_bytes);
}

double ZarrChunkReader::stored_share() const {
  double n_files = 1;
  ZarrShape counts;
  for (std::size_t axis = 0; axis < array_.shape.size(); ++axis) {
    counts.push_back((array_.shape[axis] - 1) / array_.chunk_shape[axis] + 1);
    n_files *= static_cast<double>(counts.back());
  }
  const auto n_looked_at =
      static_cast<std::int64_t>(std::min(n_files, static_cast<double>(kMaxFilesLookedAt)));
  double n_bytes = 0;
  for (std::int64_t i = 0; i < n_looked_at; ++i) {
    // In the middle of one of as many stretches.
    auto rest = static_cast<std::int64_t>((static_cast<double>(i) + 0.5) * n_files /
                                          static_cast<double>(n_looked_at));
    ZarrShape chunk(counts.size(), 0);
    for (std::size_t axis = counts.size(); axis > 0; --axis) {
      chunk[axis - 1] = rest % counts[axis - 1];
      rest /= counts[axis - 1];
    }
    n_bytes += size_or_none(chunk_path(array_, chunk));
  }
  return n_bytes /
         (static_cast<double>(n_looked_at) * static_cast<double>(product_of(array_.chunk_shape)) *
          static_cast<double>(size_of(array_.type)));
}

Result<ZarrChunkReader::Bytes> ZarrChunkReader::read(std::span<const std::int64_t> chunk) {
  ZarrShape in_grid(chunk.begin(), chunk.end());
  ZarrShape in_file(chunk.size(), 0);
  for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
    in_grid[axis] = chunk[axis] / units_.per_file[axis];
    in_file[axis] = chunk[axis] % units_.per_file[axis];
  }
  const std::string path = chunk_path(array_, in_grid);
  if (is_missing(path)) return Bytes{};
  LODE_TRY(const InputFilePtr file, InputFile::open(path, tally_));
  const bool is_shard = units_.codecs != &array_.codecs;
  return is_shard ? read_from_shard(*file, in_grid, in_file)
                  : read_part(*file, path, 0, file->size());
}

}  // namespace lode::io
