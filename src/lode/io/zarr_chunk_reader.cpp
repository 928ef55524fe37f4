#include "lode/io/zarr_chunk_reader.h"

#include <sys/stat.h>

#include <cerrno>

#include "lode/io/input_file.h"

namespace lode::io {
namespace {

/// Nothing at all has that name. Whatever has and is no file is for InputFile to complain of.
bool is_missing(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) != 0 && errno == ENOENT;
}

}  // namespace

ZarrChunkReader::ZarrChunkReader(ZarrArray array)
    : array_(std::move(array)),
      units_(units_of(array_)),
      form_{units_.shape, array_.type, array_.fill} {}

Result<ZarrChunkReader::Bytes> ZarrChunkReader::read_file(const std::string& path) {
  if (is_missing(path)) return Bytes{};
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  LODE_CHECK(check_stored_size(path, *units_.codecs, form_, file->size()));
  std::vector<std::byte> stored(static_cast<std::size_t>(file->size()));
  LODE_CHECK(file->read(0, stored));
  LODE_TRY(std::vector<std::byte> samples, decode_chunk(path, *units_.codecs, form_, stored));
  return std::make_shared<const std::vector<std::byte>>(std::move(samples));
}

Result<ZarrChunkReader::Bytes> ZarrChunkReader::read(std::span<const std::int64_t> chunk) {
  return read_file(chunk_path(array_, chunk));
}

}  // namespace lode::io
