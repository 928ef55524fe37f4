#include "lode/io/metaimage.h"

#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "lode/io/deflated_samples.h"
#include "lode/io/image_grid.h"
#include "lode/io/text.h"
#include "lode/io/text_cursor.h"
#include "lode/io/text_samples.h"

namespace lode::io {
namespace {

struct MetaHeader {
  std::string path;
  std::map<std::string, std::string> fields;  ///< Keys in lower case.
  std::uint64_t end = 0;

  /// The first of `keys` that is there.
  const std::string* find(std::initializer_list<const char*> keys) const {
    for (const char* key : keys)
      if (const auto it = fields.find(key); it != fields.end()) return &it->second;
    return nullptr;
  }
};

Result<MetaHeader> read_meta_header(const InputFilePtr& file) {
  constexpr std::uint64_t kMaxHeader = 1 << 20;
  auto stream = make_file_stream(file, 0);
  TextCursor cursor(*stream, file->path());
  MetaHeader header{.path = file->path(), .fields = {}};
  while (true) {
    LODE_TRY(const auto line, cursor.line());
    if (!line || cursor.position() > kMaxHeader)
      return fail("{}: expected a MetaImage header that ends with ElementDataFile", file->path());
    if (trimmed(*line).empty()) continue;
    const std::size_t equals = line->find('=');
    if (equals == std::string::npos)
      return fail("{}: expected 'Name = value' in the MetaImage header, got {}", file->path(),
                  in_quotes(*line));
    const std::string key = to_lower(trimmed(std::string_view(*line).substr(0, equals)));
    header.fields[key] = trimmed(std::string_view(*line).substr(equals + 1));
    header.end = cursor.position();
    if (key == "elementdatafile") return header;
  }
}

Result<std::vector<double>> meta_numbers(const MetaHeader& header,
                                         std::initializer_list<const char*> keys,
                                         std::size_t n_expected) {
  const std::string* text = header.find(keys);
  if (text == nullptr) return std::vector<double>();
  const auto numbers = to_doubles(*text);
  if (!numbers || numbers->size() != n_expected)
    return fail("{}: expected {} numbers for {}, got {}", header.path, n_expected, *keys.begin(),
                in_quotes(*text));
  return *numbers;
}

Result<bool> flag_of(const MetaHeader& header, std::initializer_list<const char*> keys,
                     bool fallback) {
  const std::string* text = header.find(keys);
  if (text == nullptr) return fallback;
  if (equals_ignoring_case(*text, "true") || *text == "1") return true;
  if (equals_ignoring_case(*text, "false") || *text == "0") return false;
  return fail("{}: expected True or False for {}, got {}", header.path, *keys.begin(),
              in_quotes(*text));
}

Result<ScalarType> parse_meta_type(const MetaHeader& header) {
  using enum ScalarType;
  const std::string* text = header.find({"elementtype"});
  if (text == nullptr) return fail("{}: expected ElementType in the header", header.path);
  std::string name = *text;
  if (name.ends_with("_ARRAY")) name.resize(name.size() - 6);
  // MetaIO's LONG has 4 bytes on every machine.
  constexpr std::array<std::pair<std::string_view, ScalarType>, 12> kTypes = {{
      {"MET_UCHAR", uint8},
      {"MET_CHAR", int8},
      {"MET_USHORT", uint16},
      {"MET_SHORT", int16},
      {"MET_UINT", uint32},
      {"MET_INT", int32},
      {"MET_ULONG", uint32},
      {"MET_LONG", int32},
      {"MET_ULONG_LONG", uint64},
      {"MET_LONG_LONG", int64},
      {"MET_FLOAT", float32},
      {"MET_DOUBLE", float64},
  }};
  for (const auto& [spelling, type] : kTypes)
    if (name == spelling) return type;
  return fail("{}: expected an ElementType like MET_SHORT, got {}", header.path, in_quotes(*text));
}

/// Which way +x, +y and +z of the world point, e.g. "LPS", from the letters of the sides that the
/// image axes come from and the axes' directions; empty where they do not say.
std::string world_axes(const std::string& letters, const Mat3& direction) {
  constexpr std::string_view kSides = "RLAPIS";
  std::string world = "???";
  if (letters.size() != 3) return {};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t from = kSides.find(letters[axis]);
    if (from == std::string_view::npos) return {};
    const Vec3d column = direction.column(axis);
    std::size_t along = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (std::abs(column[i]) > std::abs(column[along])) along = i;
    // Sides lie in the list as opposite pairs.
    world[along] = kSides[column[along] > 0 ? from ^ std::size_t{1} : from];
  }
  return world.find('?') == std::string::npos ? world : std::string();
}

std::string note_meta_frame(const MetaHeader& header, const Mat3& direction, Frame& frame) {
  const std::string* letters = header.find({"anatomicalorientation"});
  if (letters == nullptr) return "the header has no AnatomicalOrientation";
  const std::string world = world_axes(*letters, direction);
  if (world == "LPS") frame = Frame::lps;
  if (world == "RAS") frame = Frame::ras;
  return fmt::format("AnatomicalOrientation = {} (world axes {})", in_quotes(*letters),
                     world.empty() ? "unknown" : world);
}

struct MetaShape {
  std::size_t n_dims = 0;
  std::array<std::int64_t, 4> counts = {1, 1, 1, 1};
  std::int64_t n_channels = 1;
};

Result<MetaShape> parse_shape(const MetaHeader& header) {
  MetaShape shape;
  const std::string* n_dims = header.find({"ndims"});
  const auto n = n_dims == nullptr ? std::nullopt : to_int64(*n_dims);
  if (!n || *n < 1 || *n > 4)
    return fail("{}: expected NDims between 1 and 4, got {}", header.path,
                n_dims == nullptr ? "none" : in_quotes(*n_dims));
  shape.n_dims = static_cast<std::size_t>(*n);
  const std::string* sizes_text = header.find({"dimsize"});
  const auto sizes = sizes_text == nullptr ? std::nullopt : to_int64s(*sizes_text);
  if (!sizes || sizes->size() != shape.n_dims)
    return fail("{}: expected {} numbers for DimSize, got {}", header.path, shape.n_dims,
                sizes_text == nullptr ? "none" : in_quotes(*sizes_text));
  for (std::size_t i = 0; i < shape.n_dims; ++i) shape.counts[i] = (*sizes)[i];
  if (const std::string* channels = header.find({"elementnumberofchannels"})) {
    const auto n_channels = to_int64(*channels);
    if (!n_channels || *n_channels < 1)
      return fail("{}: expected ElementNumberOfChannels of at least 1, got {}", header.path,
                  in_quotes(*channels));
    shape.n_channels = *n_channels;
  }
  return shape;
}

Result<RegularGrid> parse_meta_grid(const MetaHeader& header, const MetaShape& shape,
                                    std::string& frame_note) {
  const std::size_t n = shape.n_dims;
  GridFrame frame;
  LODE_TRY(frame.dims, checked_dims(header.path, std::span(shape.counts).first(3)));
  LODE_TRY(const auto spacing, meta_numbers(header, {"elementspacing", "elementsize"}, n));
  LODE_TRY(const auto origin, meta_numbers(header, {"offset", "position", "origin"}, n));
  LODE_TRY(const auto matrix,
           meta_numbers(header, {"transformmatrix", "rotation", "orientation"}, n * n));
  for (std::size_t i = 0; i < std::min<std::size_t>(n, 3); ++i) {
    if (!spacing.empty()) frame.spacing[i] = spacing[i];
    if (!origin.empty()) frame.origin[i] = origin[i];
    // MetaIO writes the direction of one image axis after the other.
    for (std::size_t j = 0; j < std::min<std::size_t>(n, 3) && !matrix.empty(); ++j)
      frame.direction.rows[j][i] = matrix[i * n + j];
  }
  frame_note = note_meta_frame(header, frame.direction, frame.frame);
  return make_grid(header.path, frame);
}

enum class MetaEncoding { raw, zlib, text };

struct MetaData {
  InputFilePtr file;
  std::uint64_t offset = 0;
  MetaEncoding encoding = MetaEncoding::raw;
};

Result<MetaData> find_meta_data(const InputFilePtr& file, const MetaHeader& header,
                                std::uint64_t n_bytes) {
  LODE_TRY(const bool is_compressed, flag_of(header, {"compresseddata"}, false));
  LODE_TRY(const bool is_binary, flag_of(header, {"binarydata"}, true));
  MetaData data{.file = file, .offset = header.end};
  data.encoding = is_compressed ? MetaEncoding::zlib
                  : is_binary   ? MetaEncoding::raw
                                : MetaEncoding::text;
  const std::string& name = *header.find({"elementdatafile"});
  if (!equals_ignoring_case(name, "local")) {
    if (name.empty() || name.starts_with("LIST") || name.find('%') != std::string::npos)
      return fail("{}: expected one ElementDataFile, got {}", header.path, in_quotes(name));
    LODE_TRY(data.file, InputFile::open(path_beside(header.path, name), file->tally()));
    data.offset = 0;
  }
  const std::string* skip_text = header.find({"headersize"});
  if (skip_text == nullptr) return data;
  const auto skip = to_int64(*skip_text);
  if (!skip || *skip < -1 || (*skip == -1 && is_compressed))
    return fail("{}: expected HeaderSize of -1 (uncompressed only) or more, got {}", header.path,
                in_quotes(*skip_text));
  // -1: the samples are the last bytes of the file.
  const std::uint64_t n_left = data.file->size_from(data.offset);
  const std::uint64_t n_skipped =
      *skip >= 0 ? static_cast<std::uint64_t>(*skip) : n_left - std::min(n_left, n_bytes);
  if (n_skipped > n_left)
    return fail("{}: HeaderSize is {}, but the data file has only {} bytes", header.path, *skip,
                n_left);
  data.offset += n_skipped;
  return data;
}

Result<std::unique_ptr<SampleStore>> load_meta_data(const MetaData& data, ScalarType type,
                                                    std::uint64_t n_bytes,
                                                    const SampleStorage& storage) {
  switch (data.encoding) {
    case MetaEncoding::zlib:
      return load_inflated({.file = data.file, .offset = data.offset, .n_bytes = n_bytes}, storage);
    case MetaEncoding::text:
      return load_text({.file = data.file, .offset = data.offset, .type = type, .n_bytes = n_bytes},
                       storage);
    case MetaEncoding::raw: break;
  }
  return make_file_store(data.file, data.offset, n_bytes);
}

}  // namespace

Result<Image> read_metaimage(const std::string& path, const SampleStorage& storage) {
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  LODE_TRY(const MetaHeader header, read_meta_header(file));
  LODE_TRY(const ScalarType type, parse_meta_type(header));
  LODE_TRY(const MetaShape shape, parse_shape(header));
  Image image{.path = path,
              .format = {},
              .frame_note = {},
              .grid = {},
              .fields = {},
              .tally = file->tally()};
  LODE_TRY(image.grid, parse_meta_grid(header, shape, image.frame_note));
  // MetaIO writes "?" where it does not know.
  if (const std::string* unit = header.find({"distanceunits"}); unit != nullptr && *unit != "?")
    image.length_unit = *unit;
  ImageField field;
  LODE_TRY(field.layout,
           interleaved_layout(path, image.grid.dims, type, shape.n_channels, shape.counts[3]));
  const std::uint64_t n_bytes = field.layout.n_bytes;
  LODE_TRY(const MetaData data, find_meta_data(file, header, n_bytes));
  LODE_TRY(const bool is_big_endian,
           flag_of(header, {"binarydatabyteordermsb", "elementbyteordermsb"}, false));
  field.layout.byte_order = is_big_endian ? ByteOrder::big : ByteOrder::little;
  if (data.encoding == MetaEncoding::text) field.layout.byte_order = native_byte_order();
  constexpr std::array<std::string_view, 3> kEncodings = {"raw", "zlib", "text"};
  image.format = fmt::format("MetaImage, {}", kEncodings[static_cast<std::size_t>(data.encoding)]);
  field.load = [data, type, n_bytes, storage] {
    return load_meta_data(data, type, n_bytes, storage);
  };
  image.fields.push_back(std::move(field));
  return image;
}

}  // namespace lode::io
