#include "lode/io/nrrd.h"

#include <algorithm>
#include <utility>

#include "lode/io/deflated_samples.h"
#include "lode/io/nrrd_axes.h"
#include "lode/io/nrrd_files.h"
#include "lode/io/text.h"
#include "lode/io/text_cursor.h"
#include "lode/io/text_samples.h"

namespace lode::io {
namespace {

enum class NrrdEncoding { raw, gzip, text, hex };

/// Where the samples are and how they are written.
struct NrrdData {
  InputFilePtr file;               ///< With or without a header; none where there are several.
  std::vector<std::string> paths;  ///< Of several data files, in the order of their samples.
  IoTallyPtr tally;                ///< Of all files.
  std::uint64_t offset = 0;        ///< Of the first byte after the header.
  std::int64_t line_skip = 0;
  std::int64_t byte_skip = 0;  ///< -1: the samples are the last bytes of the file (raw only).
  NrrdEncoding encoding = NrrdEncoding::raw;
  ScalarType type = ScalarType::uint8;
};

struct NrrdHeader {
  NrrdFields fields;
  std::vector<std::string> data_files;  ///< The lines after "data file: LIST".
  std::uint64_t end = 0;
};

/// Folds the spellings the standard allows into one.
std::string canonical_key(std::string_view key) {
  std::string name = to_lower(trimmed(key));
  constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kSpellings = {{
      {"datafile", "data file"},
      {"axismins", "axis mins"},
      {"axismaxs", "axis maxs"},
      {"byteskip", "byte skip"},
      {"lineskip", "line skip"},
      {"centers", "centerings"},
  }};
  for (const auto& [spelling, canonical] : kSpellings)
    if (name == spelling) return std::string(canonical);
  return name;
}

Result<NrrdHeader> read_nrrd_header(const InputFilePtr& file) {
  constexpr std::uint64_t kMaxHeader = 1 << 20;
  auto stream = make_file_stream(file, 0);
  TextCursor cursor(*stream, file->path());
  LODE_TRY(auto line, cursor.line());
  if (!line || !line->starts_with("NRRD000"))
    return fail("{}: expected a NRRD file to start with NRRD000, got {}", file->path(),
                in_quotes(line.value_or("")));
  NrrdHeader header;
  bool is_listing = false;
  while (true) {
    LODE_TRY(line, cursor.line());
    header.end = cursor.position();
    if (!line || line->empty()) return header;
    if (header.end > kMaxHeader)
      return fail("{}: expected a header of at most {} bytes", file->path(), kMaxHeader);
    if (is_listing) {
      header.data_files.emplace_back(trimmed(*line));
      continue;
    }
    if (line->front() == '#') continue;
    const std::size_t colon = line->find(':');
    if (colon == std::string::npos)
      return fail("{}: expected 'field: value' in the NRRD header, got {}", file->path(),
                  in_quotes(*line));
    // "key:=value" pairs are the user's own.
    if (line->substr(colon).starts_with(":=")) continue;
    const std::string_view value = trimmed(std::string_view(*line).substr(colon + 1));
    const std::string key = canonical_key(std::string_view(*line).substr(0, colon));
    header.fields[key] = value;
    is_listing = key == "data file" && is_list_of_lines(value);
  }
}

Result<ScalarType> parse_nrrd_type(const std::string& path, const NrrdFields& fields) {
  const auto it = fields.find("type");
  if (it == fields.end()) return fail("{}: expected the field 'type' in the NRRD header", path);
  std::string name = to_lower(it->second);
  // The standard's longer spellings, brought to the ones that core knows.
  constexpr std::array<std::pair<std::string_view, std::string_view>, 14> kSpellings = {{
      {"short int", "int16"},
      {"signed short", "int16"},
      {"signed short int", "int16"},
      {"unsigned short int", "uint16"},
      {"signed int", "int32"},
      {"longlong", "int64"},
      {"long long", "int64"},
      {"long long int", "int64"},
      {"signed long long", "int64"},
      {"signed long long int", "int64"},
      {"ulonglong", "uint64"},
      {"unsigned long long", "uint64"},
      {"unsigned long long int", "uint64"},
      {"unsigned int", "uint32"},
  }};
  for (const auto& [spelling, simple] : kSpellings)
    if (name == spelling) name = simple;
  const auto type = scalar_type_from_name(name);
  if (!type) return fail("{}: expected a scalar type, got {}", path, in_quotes(it->second));
  return *type;
}

Result<NrrdEncoding> parse_encoding(const std::string& path, const NrrdFields& fields) {
  const auto it = fields.find("encoding");
  if (it == fields.end()) return fail("{}: expected the field 'encoding' in the NRRD header", path);
  const std::string name = to_lower(it->second);
  if (name == "raw") return NrrdEncoding::raw;
  if (name == "gzip" || name == "gz") return NrrdEncoding::gzip;
  if (name == "text" || name == "txt" || name == "ascii") return NrrdEncoding::text;
  if (name == "hex") return NrrdEncoding::hex;
  return fail("{}: expected the encoding raw, gzip, text or hex, got {}", path,
              in_quotes(it->second));
}

Result<ByteOrder> parse_byte_order(const std::string& path, const NrrdFields& fields,
                                   ScalarType type, NrrdEncoding encoding) {
  if (encoding == NrrdEncoding::text) return native_byte_order();
  const auto it = fields.find("endian");
  if (it == fields.end()) {
    if (size_of(type) == 1) return ByteOrder::little;
    return fail("{}: expected the field 'endian' for samples of type {}", path, name_of(type));
  }
  const std::string name = to_lower(it->second);
  if (name == "little") return ByteOrder::little;
  if (name == "big") return ByteOrder::big;
  return fail("{}: expected endian little or big, got {}", path, in_quotes(it->second));
}

Result<std::int64_t> parse_skip(const std::string& path, const NrrdFields& fields, const char* key,
                                std::int64_t lowest) {
  const auto it = fields.find(key);
  if (it == fields.end()) return 0;
  const auto skip = to_int64(it->second);
  if (!skip || *skip < lowest)
    return fail("{}: expected '{}' of at least {}, got {}", path, key, lowest,
                in_quotes(it->second));
  return *skip;
}

Result<std::uint64_t> skip_lines(const InputFilePtr& file, std::uint64_t offset, std::int64_t n) {
  auto stream = make_file_stream(file, offset);
  TextCursor cursor(*stream, file->path());
  for (std::int64_t i = 0; i < n; ++i) {
    LODE_TRY(const auto line, cursor.line());
    if (!line) return fail("{}: expected {} lines before the samples, got {}", file->path(), n, i);
  }
  return offset + cursor.position();
}

Result<NrrdData> find_nrrd_data(const InputFilePtr& header_file, const NrrdHeader& header) {
  const std::string& path = header_file->path();
  NrrdData data{
      .file = header_file, .paths = {}, .tally = header_file->tally(), .offset = header.end};
  LODE_TRY(data.encoding, parse_encoding(path, header.fields));
  if (const auto it = header.fields.find("data file"); it != header.fields.end()) {
    const std::string& value = it->second;
    data.offset = 0;
    if (is_file_list(value)) {
      data.file = nullptr;
      const auto sizes = to_int64s(header.fields.at("sizes"));  // known to be numbers
      LODE_TRY(data.paths, parse_file_list(path, value, header.data_files, *sizes));
      for (std::string& name : data.paths) name = path_beside(path, name);
    } else {
      LODE_TRY(data.file, InputFile::open(path_beside(path, value), header_file->tally()));
    }
  }
  LODE_TRY(data.line_skip, parse_skip(path, header.fields, "line skip", 0));
  LODE_TRY(data.byte_skip, parse_skip(path, header.fields, "byte skip", -1));
  return data;
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

/// The samples of one file.
Result<std::unique_ptr<SampleStore>> load_nrrd_file(const InputFilePtr& file, const NrrdData& data,
                                                    std::uint64_t n_bytes,
                                                    const SampleStorage& storage) {
  const std::string& path = file->path();
  LODE_TRY(const std::uint64_t start, skip_lines(file, data.offset, data.line_skip));
  if (data.byte_skip < 0) {
    if (data.encoding != NrrdEncoding::raw)
      return fail("{}: 'byte skip: -1' is defined for raw encoding only", path);
    if (file->size_from(start) < n_bytes)
      return fail("{}: expected {} bytes of samples, got {}", path, n_bytes,
                  file->size_from(start));
    return make_file_store(file, file->size() - n_bytes, n_bytes);
  }
  const auto skip = static_cast<std::uint64_t>(data.byte_skip);
  // In compressed data the bytes to skip are counted after decompression.
  if (data.encoding == NrrdEncoding::gzip)
    return load_inflated({.file = file, .offset = start, .n_skipped = skip, .n_bytes = n_bytes},
                         storage);
  if (skip > file->size_from(start))
    return fail("{}: expected to skip {} bytes, the file has {}", path, skip, file->size());
  const std::uint64_t offset = start + skip;
  if (data.encoding == NrrdEncoding::text)
    return load_text({.file = file, .offset = offset, .type = data.type, .n_bytes = n_bytes},
                     storage);
  if (data.encoding == NrrdEncoding::hex) return load_hex(file, offset, n_bytes, storage);
  return make_file_store(file, offset, n_bytes);
}

/// Several files are read into memory one after the other: slices may be more than a process may
/// hold open.
Result<std::unique_ptr<SampleStore>> load_nrrd_data(const NrrdData& data, std::uint64_t n_bytes,
                                                    const SampleStorage& storage) {
  if (data.file) return load_nrrd_file(data.file, data, n_bytes, storage);
  const std::uint64_t n_each = n_bytes / data.paths.size();
  std::vector<std::byte> bytes;
  for (const std::string& path : data.paths) {
    LODE_TRY(const InputFilePtr file, InputFile::open(path, data.tally));
    LODE_TRY(const auto store, load_nrrd_file(file, data, n_each, storage));
    bytes.resize(bytes.size() + static_cast<std::size_t>(n_each));
    LODE_CHECK(store->read(0, std::span(bytes).last(static_cast<std::size_t>(n_each))));
  }
  return make_memory_store(std::move(bytes));
}

std::string_view name_of(NrrdEncoding encoding) {
  constexpr std::array<std::string_view, 4> kNames = {"raw", "gzip", "text", "hex"};
  return kNames[static_cast<std::size_t>(encoding)];
}

}  // namespace

Result<Image> read_nrrd(const std::string& path, const SampleStorage& storage) {
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  LODE_TRY(const NrrdHeader header, read_nrrd_header(file));
  LODE_TRY(const ScalarType type, parse_nrrd_type(path, header.fields));
  LODE_TRY(NrrdAxes axes, parse_nrrd_axes(path, header.fields, type));
  LODE_TRY(NrrdData data, find_nrrd_data(file, header));
  data.type = type;
  LODE_TRY(axes.layout.byte_order, parse_byte_order(path, header.fields, type, data.encoding));
  const std::uint64_t n_bytes = axes.layout.n_bytes;
  Image image{.path = path,
              .format = fmt::format("NRRD, {}", name_of(data.encoding)),
              .frame_note = std::move(axes.frame_note),
              .grid = axes.grid,
              .fields = {},
              .tally = file->tally()};
  ImageField field{.name = {}, .layout = axes.layout, .load = [data, n_bytes, storage] {
                     return load_nrrd_data(data, n_bytes, storage);
                   }};
  image.fields.push_back(std::move(field));
  return image;
}

}  // namespace lode::io
