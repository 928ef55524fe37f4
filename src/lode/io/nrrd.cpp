#include "lode/io/nrrd.h"

#include <algorithm>
#include <utility>

#include "lode/io/nrrd_axes.h"
#include "lode/io/nrrd_data.h"
#include "lode/io/nrrd_files.h"
#include "lode/io/nrrd_units.h"
#include "lode/io/text.h"
#include "lode/io/text_cursor.h"
#include "lode/io/text_samples.h"

namespace lode::io {
namespace {

struct NrrdHeader {
  NrrdFields fields;
  std::vector<std::string> data_files;  ///< The lines after "data file: LIST".
  std::uint64_t end = 0;
};

/// Folds the spellings the standard allows into one.
std::string canonical_key(std::string_view key) {
  std::string name = to_lower(trimmed(key));
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kSpellings = {{
      {"datafile", "data file"},
      {"axismins", "axis mins"},
      {"axismaxs", "axis maxs"},
      {"byteskip", "byte skip"},
      {"lineskip", "line skip"},
      {"centers", "centerings"},
      {"sampleunits", "sample units"},
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
              .tally = file->tally(),
              .length_unit = std::move(axes.length_unit)};
  ImageField field{.name = {}, .layout = axes.layout, .load = [data, n_bytes, storage] {
                     return load_nrrd_data(data, n_bytes, storage);
                   }};
  field.value_unit = nrrd_value_unit(header.fields);
  image.fields.push_back(std::move(field));
  return image;
}

}  // namespace lode::io
