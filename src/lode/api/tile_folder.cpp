#include "lode/api/tile_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "lode/io/input_file.h"
#include "lode/io/quantized_mesh.h"

namespace lode {
namespace {

using tile_pyramid::DegreeBox;
using tile_pyramid::FinishedTile;
using tile_pyramid::LevelReport;
using tile_pyramid::TileRange;
using Json = nlohmann::ordered_json;

/// What a tile counts its heights in: the level's step, halved for as long as they fit. Clients
/// cull and choose levels by the highest height that its header has, which is that many units up.
double unit_of(double step, double lowest, double highest) {
  constexpr double kMostNumber = 1 << 24;     // that float32 has with all below
  constexpr double kLeast = 1.0 / (1 << 30);  // of steps
  const auto fits = [&](double unit) {
    return unit >= kLeast && (highest - lowest) / unit <= io::QuantizedMesh::kLast &&
           std::abs(lowest) / unit + io::QuantizedMesh::kLast <= kMostNumber;
  };
  while (fits(step / 2)) step /= 2;
  return step;
}

io::QuantizedMesh to_quantized(const FinishedTile& tile) {
  const double size = tile_pyramid::tile_size(tile.id.level);
  io::QuantizedMesh mesh{.west = west_of(tile.id), .south = south_of(tile.id)};
  mesh.east = mesh.west + size;
  mesh.north = mesh.south + size;
  const auto& vertices = tile.mesh.vertices;
  const auto [low, high] = std::ranges::minmax(vertices, {}, &tile_pyramid::TileVertex::height);
  const double unit = unit_of(tile.form.height_step, low.height, high.height);
  mesh.lowest = low.height;
  mesh.highest = low.height + io::QuantizedMesh::kLast * unit;
  for (const auto& vertex : vertices) {
    mesh.nodes.push_back(vertex.node);
    mesh.heights.push_back(static_cast<std::uint16_t>((vertex.height - mesh.lowest) / unit));
  }
  mesh.triangles = tile.mesh.triangles;
  return mesh;
}

Result<void> write_file(const std::filesystem::path& path, const void* bytes, std::size_t n) {
  std::ofstream file(path, std::ios::binary);
  file.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(n));
  file.close();
  if (!file) return fail("{}: cannot write {} bytes: {}", path.string(), n, io::system_message());
  return {};
}

/// A range whose columns run beyond 180 degrees is two.
Json available_in(const TileRange& range) {
  Json parts = Json::array();
  const std::int64_t n_all = std::int64_t{2} << range.level;
  const std::int64_t first = tile_pyramid::wrapped_column(range.level, range.first_x);
  const std::int64_t last = first + range.n_columns() - 1;
  const auto add = [&](std::int64_t from, std::int64_t to) {
    parts.push_back(
        {{"startX", from}, {"startY", range.first_y}, {"endX", to}, {"endY", range.last_y}});
  };
  add(first, std::min(last, n_all - 1));
  if (last >= n_all) add(0, last - n_all);
  return parts;
}

}  // namespace

Result<void> TileFolder::add(const FinishedTile& tile) {
  const std::filesystem::path folder =
      std::filesystem::path(folder_) / fmt::to_string(tile.id.level) / fmt::to_string(tile.id.x);
  std::error_code status;
  std::filesystem::create_directories(folder, status);
  if (status) return fail("{}: cannot make the folder: {}", folder.string(), status.message());
  const std::vector<std::byte> bytes = io::encode(to_quantized(tile));
  n_bytes_[static_cast<std::size_t>(tile.id.level)] += bytes.size();
  return write_file(folder / fmt::format("{}.terrain", tile.id.y), bytes.data(), bytes.size());
}

Result<void> TileFolder::write_layer(std::span<const LevelReport> levels,
                                     const DegreeBox& bounds) const {
  // Beyond 180 degrees boxes go from east to west.
  const double turns = 360 * std::floor((bounds.west + 180) / 360);
  const bool is_round = bounds.east - bounds.west >= 360;
  const double west = is_round ? -180 : bounds.west - turns;
  const double east = is_round ? 180 : bounds.east - turns - (bounds.east - turns > 180 ? 360 : 0);
  Json layer;
  layer["tilejson"] = "2.1.0";
  layer["name"] = "terrain";
  layer["version"] = "1.0.0";
  layer["format"] = "quantized-mesh-1.0";
  layer["scheme"] = "tms";
  layer["projection"] = "EPSG:4326";
  layer["tiles"] = {"{z}/{x}/{y}.terrain?v={version}"};
  layer["minzoom"] = 0;
  layer["maxzoom"] = levels.size() - 1;
  layer["bounds"] = {west, bounds.south, east, bounds.north};
  layer["attribution"] = "";
  layer["available"] = Json::array();
  layer["errors"] = Json::array();
  for (const LevelReport& level : levels) {
    layer["available"].push_back(available_in(level.range));
    layer["errors"].push_back({{"max_error", level.form.max_error},
                               {"achieved_error", level.error},
                               {"height_step", level.form.height_step}});
  }
  const std::string text = layer.dump(2) + "\n";
  return write_file(std::filesystem::path(folder_) / "layer.json", text.data(), text.size());
}

}  // namespace lode
