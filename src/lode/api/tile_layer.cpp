#include "lode/api/tile_layer.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "lode/io/input_file.h"

namespace lode {
namespace {

using nlohmann::json;
using tile_pyramid::TileRange;

Result<std::vector<std::byte>> read_bytes(const std::filesystem::path& path) {
  LODE_TRY(const io::InputFilePtr file, io::InputFile::open(path.string()));
  std::vector<std::byte> bytes(file->size());
  LODE_CHECK(file->read(0, bytes));
  return bytes;
}

Result<void> check_text(const std::string& path, const json& layer, const char* key,
                        std::string_view expected) {
  const auto found = layer.find(key);
  const bool is_text = found != layer.end() && found->is_string();
  if (is_text && found->get<std::string>() == expected) return {};
  return fail("{}: {}: expected {}, got {}", path, key, expected,
              is_text ? found->get<std::string>() : "none");
}

/// A whole number from 0 to `last`.
Result<std::int64_t> number_in(const std::string& path, const json& part, const char* key,
                               std::int64_t last) {
  const auto found = part.find(key);
  if (found != part.end() && found->is_number_integer()) {
    const auto value = found->get<std::int64_t>();
    if (value >= 0 && value <= last) return value;
  }
  return fail("{}: available: {}: expected a whole number from 0 to {}", path, key, last);
}

Result<TileRange> range_of(const std::string& path, const json& part, int level) {
  if (!part.is_object()) return fail("{}: available: expected ranges of tiles", path);
  const std::int64_t last_x = (std::int64_t{2} << level) - 1;
  const std::int64_t last_y = (std::int64_t{1} << level) - 1;
  TileRange range{.level = level};
  LODE_TRY(range.first_x, number_in(path, part, "startX", last_x));
  LODE_TRY(range.last_x, number_in(path, part, "endX", last_x));
  LODE_TRY(range.first_y, number_in(path, part, "startY", last_y));
  LODE_TRY(range.last_y, number_in(path, part, "endY", last_y));
  if (range.first_x > range.last_x || range.first_y > range.last_y)
    return fail("{}: available: expected ranges of one tile or more on level {}", path, level);
  return range;
}

Result<void> read_errors(const std::string& path, const json& layer, TileLayer& out) {
  const auto errors = layer.find("errors");
  if (errors == layer.end()) return {};
  if (!errors->is_array() || errors->size() != out.levels.size())
    return fail("{}: errors: expected one for each of {} levels", path, out.levels.size());
  for (std::size_t level = 0; level < out.levels.size(); ++level) {
    const json& part = (*errors)[level];
    const bool is_known =
        part.is_object() && part.contains("achieved_error") && part["achieved_error"].is_number();
    const double error = is_known ? part["achieved_error"].get<double>() : -1;
    if (!(error >= 0)) return fail("{}: errors: expected achieved_error >= 0", path);
    out.levels[level].error = error;
  }
  return {};
}

}  // namespace

Result<TileLayer> read_layer(const std::string& folder) {
  const std::string path = (std::filesystem::path(folder) / "layer.json").string();
  LODE_TRY(const auto text, read_bytes(path));
  const auto* first = reinterpret_cast<const char*>(text.data());
  const json layer = json::parse(first, first + text.size(), nullptr, false);
  if (!layer.is_object()) return fail("{}: expected an object of JSON", path);
  LODE_CHECK(check_text(path, layer, "format", "quantized-mesh-1.0"));
  LODE_CHECK(check_text(path, layer, "scheme", "tms"));
  if (layer.contains("projection")) LODE_CHECK(check_text(path, layer, "projection", "EPSG:4326"));
  const auto available = layer.find("available");
  if (available == layer.end() || !available->is_array() || available->empty() ||
      available->size() > tile_pyramid::kMaxLevel + 1)
    return fail("{}: available: expected ranges of tiles of 1 to {} levels", path,
                tile_pyramid::kMaxLevel + 1);
  TileLayer out;
  for (const json& level : *available) {
    if (!level.is_array()) return fail("{}: available: expected ranges of tiles", path);
    TileLayer::Level& own = out.levels.emplace_back();
    for (const json& part : level) {
      LODE_TRY(const TileRange range,
               range_of(path, part, static_cast<int>(out.levels.size()) - 1));
      own.ranges.push_back(range);
    }
  }
  LODE_CHECK(read_errors(path, layer, out));
  return out;
}

Result<io::QuantizedMesh> read_tile(const std::string& folder, const tile_pyramid::TileId& tile) {
  const std::filesystem::path path = std::filesystem::path(folder) / fmt::to_string(tile.level) /
                                     fmt::to_string(tile.x) / fmt::format("{}.terrain", tile.y);
  LODE_TRY(const auto bytes, read_bytes(path));
  const double size = tile_pyramid::tile_size(tile.level);
  return io::decode_quantized_mesh(bytes, west_of(tile), south_of(tile), west_of(tile) + size,
                                   south_of(tile) + size, path.string());
}

}  // namespace lode
