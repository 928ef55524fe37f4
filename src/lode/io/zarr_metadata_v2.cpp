#include <nlohmann/json.hpp>

#include "lode/io/text.h"
#include "lode/io/zarr_json.h"
#include "lode/io/zarr_metadata.h"

namespace lode::io {
namespace {

using nlohmann::json;

struct ZarrType {
  ScalarType type = ScalarType::uint8;
  ByteOrder byte_order = ByteOrder::little;
};

/// "<u2": byte order, kind and size, as NumPy writes them.
Result<ZarrType> parse_dtype(const std::string& path, const json& metadata) {
  struct Entry {
    std::string_view name;
    ScalarType type;
  };
  constexpr std::array<Entry, 10> kTypes = {{{"u1", ScalarType::uint8},
                                             {"i1", ScalarType::int8},
                                             {"u2", ScalarType::uint16},
                                             {"i2", ScalarType::int16},
                                             {"u4", ScalarType::uint32},
                                             {"i4", ScalarType::int32},
                                             {"u8", ScalarType::uint64},
                                             {"i8", ScalarType::int64},
                                             {"f4", ScalarType::float32},
                                             {"f8", ScalarType::float64}}};
  const json* value = find_member(metadata, "dtype");
  if (value != nullptr && value->is_string()) {
    const auto& name = value->get_ref<const std::string&>();
    const char order = name.empty() ? ' ' : name[0];
    for (const Entry& entry : kTypes) {
      if (name.size() != 3 || std::string_view(name).substr(1) != entry.name) continue;
      if (order == '<' || order == '>' || (order == '|' && size_of(entry.type) == 1))
        return ZarrType{entry.type, order == '>' ? ByteOrder::big : ByteOrder::little};
    }
  }
  return fail("{}: expected a dtype u1 to u8, i1 to i8, f4 or f8 with its byte order, got {}", path,
              quoted_json(value));
}

Result<std::vector<ZarrBytesCodec>> parse_compressor(const std::string& path,
                                                     const json& metadata) {
  const json* compressor = find_member(metadata, "compressor");
  if (compressor == nullptr || compressor->is_null()) return std::vector<ZarrBytesCodec>{};
  LODE_TRY(const std::string id, json_text(path, *compressor, "id"));
  if (id == "gzip") return std::vector{ZarrBytesCodec::gzip};
  if (id == "zlib") return std::vector{ZarrBytesCodec::zlib};
  if (id == "zstd") return std::vector{ZarrBytesCodec::zstd};
  if (id == "blosc") return std::vector{ZarrBytesCodec::blosc};
  return fail("{}: expected a compressor gzip, zlib, zstd, blosc or null, got {}", path,
              in_quotes(id));
}

Result<std::vector<std::size_t>> parse_memory_order(const std::string& path, const json& metadata,
                                                    std::size_t rank) {
  LODE_TRY(const std::string order, json_text(path, metadata, "order"));
  std::vector<std::size_t> reversed;
  if (order == "C") return reversed;
  if (order != "F") return fail("{}: expected an order C or F, got {}", path, in_quotes(order));
  for (std::size_t axis = rank; axis > 0; --axis) reversed.push_back(axis - 1);
  return reversed;
}

Result<char> parse_dimension_separator(const std::string& path, const json& metadata) {
  const json* separator = find_member(metadata, "dimension_separator");
  if (separator == nullptr || json_is(*separator, ".")) return '.';
  if (json_is(*separator, "/")) return '/';
  return fail("{}: expected a dimension_separator \".\" or \"/\", got {}", path,
              quoted_json(*separator));
}

}  // namespace

Result<ZarrArray> parse_zarr_v2(const std::string& path, const json& metadata) {
  const json* format = find_member(metadata, "zarr_format");
  if (format == nullptr || *format != 2)
    return fail("{}: expected a zarr_format 2, got {}", path, quoted_json(format));
  const json* filters = find_member(metadata, "filters");
  if (filters != nullptr && !filters->is_null() && !(filters->is_array() && filters->empty()))
    return fail("{}: expected no filters, got {}", path, quoted_json(*filters));
  ZarrArray array;
  array.version = 2;
  LODE_TRY(array.shape, json_whole_numbers(path, metadata, "shape", kMaxZarrRank));
  LODE_TRY(array.chunk_shape, json_whole_numbers(path, metadata, "chunks", kMaxZarrRank));
  LODE_TRY(const ZarrType type, parse_dtype(path, metadata));
  array.type = type.type;
  array.codecs.byte_order = type.byte_order;
  LODE_TRY(array.codecs.order, parse_memory_order(path, metadata, array.shape.size()));
  LODE_TRY(array.codecs.bytes_codecs, parse_compressor(path, metadata));
  LODE_TRY(array.fill, parse_zarr_fill(path, array.type, find_member(metadata, "fill_value")));
  LODE_TRY(array.key_separator, parse_dimension_separator(path, metadata));
  return array;
}

}  // namespace lode::io
