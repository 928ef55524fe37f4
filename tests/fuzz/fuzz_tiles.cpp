// Tiles of terrain: the input is a tile's file, or the layer.json of a folder.
#include <vector>

#include "lode/api/tile_layer.h"
#include "lode/io/quantized_mesh.h"
#include "tests/fuzz/fuzz_files.h"

namespace lode::fuzz {

void run_quantized_mesh(Input input) {
  const auto mesh = io::decode_quantized_mesh(input, 0, 0, 1, 1, "a.terrain");
  if (!mesh) {
    expect(mesh.error().message.starts_with("a.terrain: "), "an error names the file");
    return;
  }
  expect(mesh->heights.size() == mesh->nodes.size(), "a height each");
  std::vector<bool> is_used(mesh->nodes.size());
  for (const auto& triangle : mesh->triangles)
    for (const std::uint32_t v : triangle) {
      expect(v < mesh->nodes.size(), "corners exist");
      is_used[v] = true;
    }
  for (const bool used : is_used)
    if (!used) return;
  if (mesh->nodes.empty()) return;
  const auto again = io::decode_quantized_mesh(io::encode(*mesh), 0, 0, 1, 1, "b.terrain");
  expect(again && again->triangles.size() == mesh->triangles.size(), "a mesh comes back");
}

void run_tile_layer(Input input) {
  const std::string path = fuzz_directory().write("layer.json", input);
  const auto layer = read_layer(std::filesystem::path(path).parent_path().string());
  if (!layer) {
    expect(layer.error().message.find("layer.json") != std::string::npos,
           "an error names the file");
    return;
  }
  for (std::size_t level = 0; level < layer->levels.size(); ++level)
    for (const tile_pyramid::TileRange& range : layer->levels[level].ranges) {
      expect(range.first_x >= 0 && range.first_y >= 0, "tiles are counted from 0");
      expect(range.last_x < std::int64_t{2} << level, "columns exist");
      expect(range.last_y < std::int64_t{1} << level, "rows exist");
      expect(range.first_x <= range.last_x && range.first_y <= range.last_y, "ranges have tiles");
    }
}

}  // namespace lode::fuzz
