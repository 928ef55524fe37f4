#include <algorithm>
#include <nlohmann/json.hpp>

#include "lode/io/text.h"
#include "lode/io/zarr_json.h"
#include "lode/io/zarr_metadata.h"

namespace lode::io {
namespace {

using nlohmann::json;

constexpr std::array kKnownMembers = {
    "zarr_format",        "node_type",  "shape",  "data_type",  "chunk_grid",
    "chunk_key_encoding", "fill_value", "codecs", "attributes", "storage_transformers",
    "dimension_names"};

/// What is not in the specification must be understood unless it says otherwise.
Result<void> check_members(const std::string& path, const json& metadata) {
  for (const auto& [key, value] : metadata.items()) {
    if (std::find(kKnownMembers.begin(), kKnownMembers.end(), key) != kKnownMembers.end()) continue;
    const json* must_understand = find_member(value, "must_understand");
    if (must_understand != nullptr && *must_understand == false) continue;
    return fail("{}: expected an array without extensions, got one that must be understood: {}",
                path, in_quotes(key));
  }
  const json* transformers = find_member(metadata, "storage_transformers");
  if (transformers != nullptr && !(transformers->is_array() && transformers->empty()))
    return fail("{}: expected no storage_transformers, got {}", path, quoted_json(*transformers));
  return {};
}

Result<ScalarType> parse_data_type(const std::string& path, const json& metadata) {
  constexpr std::array kTypes = {ScalarType::uint8,  ScalarType::int8,   ScalarType::uint16,
                                 ScalarType::int16,  ScalarType::uint32, ScalarType::int32,
                                 ScalarType::uint64, ScalarType::int64,  ScalarType::float32,
                                 ScalarType::float64};
  LODE_TRY(const ZarrExtension extension,
           parse_zarr_extension(path, find_member(metadata, "data_type"), "data_type"));
  for (const ScalarType type : kTypes)
    if (extension.name == name_of(type)) return type;
  return fail("{}: expected a data_type uint8 to uint64, int8 to int64, float32 or float64, got {}",
              path, in_quotes(extension.name));
}

Result<ZarrShape> parse_chunk_grid(const std::string& path, const json& metadata) {
  LODE_TRY(const ZarrExtension grid,
           parse_zarr_extension(path, find_member(metadata, "chunk_grid"), "chunk_grid"));
  if (grid.name != "regular")
    return fail("{}: expected a regular chunk_grid, got {}", path, in_quotes(grid.name));
  return json_whole_numbers(path, *grid.configuration, "chunk_shape", kMaxZarrRank);
}

Result<void> parse_chunk_keys(const std::string& path, const json& metadata, ZarrArray& array) {
  LODE_TRY(const ZarrExtension keys,
           parse_zarr_extension(path, find_member(metadata, "chunk_key_encoding"),
                                "chunk_key_encoding"));
  if (keys.name != "default" && keys.name != "v2")
    return fail("{}: expected a chunk_key_encoding default or v2, got {}", path,
                in_quotes(keys.name));
  std::string separator = keys.name == "default" ? "/" : ".";
  if (keys.configuration->contains("separator")) {
    LODE_TRY(separator, json_text(path, *keys.configuration, "separator"));
  }
  if (separator != "/" && separator != ".")
    return fail("{}: expected a separator \".\" or \"/\", got {}", path, in_quotes(separator));
  array.key_separator = separator[0];
  array.key_prefix = keys.name == "default" ? "c" + separator : "";
  return {};
}

Result<std::vector<std::string>> parse_dimension_names(const std::string& path,
                                                       const json& metadata, std::size_t rank) {
  std::vector<std::string> names;
  const json* list = find_member(metadata, "dimension_names");
  if (list == nullptr || list->is_null()) return names;
  bool is_good = list->is_array() && list->size() == rank;
  for (std::size_t axis = 0; is_good && axis < rank; ++axis) {
    const json& name = (*list)[axis];
    is_good = name.is_string() || name.is_null();
    if (is_good) names.push_back(name.is_string() ? name.get<std::string>() : "");
  }
  if (is_good) return names;
  return fail("{}: expected {} dimension_names, got {}", path, rank, quoted_json(*list));
}

}  // namespace

Result<ZarrExtension> parse_zarr_extension(const std::string& path, const json* member,
                                           std::string_view what) {
  static const json kNoConfiguration = json::object();
  if (member == nullptr) return fail("{}: expected {}, got nothing", path, what);
  const json& value = *member;
  if (value.is_string()) return ZarrExtension{value.get<std::string>(), &kNoConfiguration};
  const json* name = find_member(value, "name");
  if (name == nullptr || !name->is_string())
    return fail("{}: expected a name for {}, got {}", path, what, quoted_json(value));
  const json* configuration = find_member(value, "configuration");
  if (configuration == nullptr) configuration = &kNoConfiguration;
  if (!configuration->is_object())
    return fail("{}: expected an object for the configuration of {}, got {}", path,
                in_quotes(name->get_ref<const std::string&>()), quoted_json(*configuration));
  return ZarrExtension{name->get<std::string>(), configuration};
}

Result<ZarrArray> parse_zarr_v3(const std::string& path, const json& metadata) {
  const json* format = find_member(metadata, "zarr_format");
  if (format == nullptr || *format != 3)
    return fail("{}: expected a zarr_format 3, got {}", path, quoted_json(format));
  LODE_CHECK(check_members(path, metadata));
  ZarrArray array;
  array.version = 3;
  LODE_TRY(array.shape, json_whole_numbers(path, metadata, "shape", kMaxZarrRank));
  LODE_TRY(array.type, parse_data_type(path, metadata));
  LODE_TRY(array.chunk_shape, parse_chunk_grid(path, metadata));
  LODE_CHECK(parse_chunk_keys(path, metadata, array));
  LODE_TRY(array.fill, parse_zarr_fill(path, array.type, find_member(metadata, "fill_value")));
  LODE_TRY(array.codecs, parse_zarr_codecs(path, find_member(metadata, "codecs"),
                                           {array.shape.size(), array.type}));
  LODE_TRY(array.dimension_names, parse_dimension_names(path, metadata, array.shape.size()));
  return array;
}

}  // namespace lode::io
