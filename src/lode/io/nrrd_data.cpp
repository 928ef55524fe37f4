#include "lode/io/nrrd_data.h"

#include <span>
#include <string_view>

#include "lode/io/deflated_samples.h"
#include "lode/io/sample_parts.h"
#include "lode/io/spooled_store.h"
#include "lode/io/text.h"
#include "lode/io/text_cursor.h"
#include "lode/io/text_samples.h"

namespace lode::io {
namespace {

Result<std::uint64_t> skip_lines(const InputFilePtr& file, std::uint64_t offset, std::int64_t n) {
  auto stream = make_file_stream(file, offset);
  TextCursor cursor(*stream, file->path());
  for (std::int64_t i = 0; i < n; ++i) {
    LODE_TRY(const auto line, cursor.line());
    if (!line) return fail("{}: expected {} lines before the samples, got {}", file->path(), n, i);
  }
  return offset + cursor.position();
}

/// Pairs of hexadecimal digits, blanks ignored.
Result<std::unique_ptr<SampleStore>> load_hex(const InputFilePtr& file, std::uint64_t offset,
                                              std::uint64_t n_bytes, const SampleStorage& storage) {
  LODE_CHECK(check_held(file->path(), "hexadecimal", n_bytes, storage));
  const std::uint64_t n_left = file->size_from(offset);
  if (n_bytes > n_left / 2)
    return fail("{}: expected {} bytes as hexadecimal text, the file has {} characters",
                file->path(), n_bytes, n_left);
  std::string text(static_cast<std::size_t>(n_left), '\0');
  LODE_CHECK(file->read(offset, std::as_writable_bytes(std::span(text.data(), text.size()))));
  std::vector<std::byte> bytes(static_cast<std::size_t>(n_bytes));
  std::size_t n_digits = 0;
  constexpr std::string_view kDigits = "0123456789abcdef";
  for (const char c : to_lower(text)) {
    if (n_digits == 2 * bytes.size()) break;
    if (trimmed({&c, 1}).empty()) continue;
    const std::size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos)
      return fail("{}: expected hexadecimal digits, got {}", file->path(), in_quotes({&c, 1}));
    std::byte& byte = bytes[n_digits++ / 2];
    byte = byte << 4 | static_cast<std::byte>(digit);
  }
  if (n_digits != 2 * bytes.size())
    return fail("{}: expected {} hexadecimal digits, got {}", file->path(), 2 * bytes.size(),
                n_digits);
  return make_memory_store(std::move(bytes));
}

/// What a gzip file expands to; the bytes to skip are counted after decompression.
Result<DeflatedSamples> find_deflated(const InputFilePtr& file, const NrrdData& data,
                                      std::uint64_t n_bytes) {
  LODE_TRY(const std::uint64_t start, skip_lines(file, data.offset, data.line_skip));
  return DeflatedSamples{.file = file,
                         .offset = start,
                         .n_skipped = static_cast<std::uint64_t>(data.byte_skip),
                         .n_bytes = n_bytes};
}

/// The samples of one file.
Result<std::unique_ptr<SampleStore>> load_nrrd_file(const InputFilePtr& file, const NrrdData& data,
                                                    std::uint64_t n_bytes,
                                                    const SampleStorage& storage) {
  const std::string& path = file->path();
  if (data.encoding == NrrdEncoding::gzip) {
    LODE_TRY(const DeflatedSamples samples, find_deflated(file, data, n_bytes));
    return load_inflated(samples, storage);
  }
  LODE_TRY(const std::uint64_t start, skip_lines(file, data.offset, data.line_skip));
  if (data.byte_skip < 0) {
    if (file->size_from(start) < n_bytes)
      return fail("{}: expected {} bytes of samples, got {}", path, n_bytes,
                  file->size_from(start));
    return make_file_store(file, file->size() - n_bytes, n_bytes);
  }
  const auto skip = static_cast<std::uint64_t>(data.byte_skip);
  if (skip > file->size_from(start))
    return fail("{}: expected to skip {} bytes, the file has {}", path, skip, file->size());
  const std::uint64_t offset = start + skip;
  if (data.encoding == NrrdEncoding::text)
    return load_text({.file = file, .offset = offset, .type = data.type, .n_bytes = n_bytes},
                     storage);
  if (data.encoding == NrrdEncoding::hex) return load_hex(file, offset, n_bytes, storage);
  return make_file_store(file, offset, n_bytes);
}

/// Several files, read one after the other.
Result<std::unique_ptr<SampleStore>> load_into_memory(const NrrdData& data, std::uint64_t n_each) {
  std::vector<std::byte> bytes;
  for (const std::string& path : data.paths) {
    LODE_TRY(const InputFilePtr file, InputFile::open(path, data.tally));
    LODE_TRY(const auto store, load_nrrd_file(file, data, n_each, {}));
    bytes.resize(bytes.size() + static_cast<std::size_t>(n_each));
    LODE_CHECK(store->read(0, std::span(bytes).last(static_cast<std::size_t>(n_each))));
  }
  return make_memory_store(std::move(bytes));
}

/// Opens each part once: what a file lacks is better known before hours of reading.
template <typename Part>
Result<void> check_parts(const SampleParts<Part>& parts) {
  for (std::size_t i = 0; i < parts.n_parts; ++i)
    if (const auto part = parts.open(i); !part) return part.error();
  return {};
}

/// Several files of raw samples, each read where it is.
Result<std::unique_ptr<SampleStore>> load_raw_parts(const NrrdData& data, std::uint64_t n_each) {
  SampleParts<SampleStore> parts{.n_bytes_each = n_each, .n_parts = data.paths.size(), .open = {}};
  parts.open = [data, n_each](std::size_t i) -> Result<std::unique_ptr<SampleStore>> {
    LODE_TRY(const InputFilePtr file, InputFile::open(data.paths[i], data.tally));
    return load_nrrd_file(file, data, n_each, {});
  };
  LODE_CHECK(check_parts(parts));
  return make_parts_store(std::move(parts));
}

/// Several gzip files, decoded one after the other while they are read.
Result<std::unique_ptr<SampleStore>> load_gzip_parts(const NrrdData& data, std::uint64_t n_each,
                                                     const SampleStorage& storage) {
  SampleParts<ByteStream> parts{.n_bytes_each = n_each, .n_parts = data.paths.size(), .open = {}};
  parts.open = [data, n_each](std::size_t i) -> Result<std::unique_ptr<ByteStream>> {
    LODE_TRY(const InputFilePtr file, InputFile::open(data.paths[i], data.tally));
    LODE_TRY(const DeflatedSamples samples, find_deflated(file, data, n_each));
    return inflated_stream(samples);
  };
  LODE_CHECK(check_parts(parts));
  return make_spooled_store({.path = data.paths.front(),
                             .stream = make_parts_stream(std::move(parts)),
                             .n_bytes = n_each * data.paths.size(),
                             .tally = data.tally},
                            storage);
}

}  // namespace

Result<std::unique_ptr<SampleStore>> load_nrrd_data(const NrrdData& data, std::uint64_t n_bytes,
                                                    const SampleStorage& storage) {
  const std::string& path = data.file ? data.file->path() : data.paths.front();
  if (data.byte_skip < 0 && data.encoding != NrrdEncoding::raw)
    return fail("{}: 'byte skip: -1' is defined for raw encoding only", path);
  if (data.file) return load_nrrd_file(data.file, data, n_bytes, storage);
  const std::uint64_t n_each = n_bytes / data.paths.size();
  if (data.encoding == NrrdEncoding::text || data.encoding == NrrdEncoding::hex)
    LODE_CHECK(check_held(path, "text", n_bytes, storage));
  if (storage.holds(n_bytes)) return load_into_memory(data, n_each);
  return data.encoding == NrrdEncoding::gzip ? load_gzip_parts(data, n_each, storage)
                                             : load_raw_parts(data, n_each);
}

}  // namespace lode::io
