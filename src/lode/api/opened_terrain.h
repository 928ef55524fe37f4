#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "lode/api/terrain_pyramid.h"
#include "lode/api/terrain_source.h"
#include "lode/core/height_frame.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/height_reader.h"

namespace lode {

/// What terrain is asked of: a TIN made anew for each question, or a pyramid.
enum class TerrainModel : std::uint8_t { delaunay_selector, delaunay_pyramid };

/// As --model and outputs name it.
[[nodiscard]] const char* name_of(TerrainModel model);

/// What a file says of its terrain.
struct TerrainFacts {
  HeightFrame frame;
  std::string format;      ///< GDAL's name of a raster's, HGT, or LODE.
  std::string type;        ///< Of the raster's samples; see HeightRaster.
  bool has_place = false;  ///< See HeightRaster.
  std::uint64_t n_missing = 0;
};

[[nodiscard]] TerrainFacts facts_of(const io::HeightRaster& raster);

/// A terrain from a file, ready to be asked.
struct OpenedTerrain {
  Terrain terrain;
  TerrainModel model = TerrainModel::delaunay_selector;
  TerrainFacts facts;
  std::optional<TerrainPyramid> pyramid{};  ///< Of the model delaunay_pyramid.
};

/// Whether a path is read as terrain: it is a raster of heights by its name, or a .lode file of a
/// model of terrain.
[[nodiscard]] bool holds_terrain(const std::string& path);
/// Whether it is such a .lode file.
[[nodiscard]] bool holds_terrain_model(const std::string& path);

/// Of a raster: with `pyramid`, one is built of it first. Of a .lode file the options of reading
/// and of pyramids mean nothing. Fails as reading and building do, naming the file.
[[nodiscard]] Result<OpenedTerrain> open_terrain(const std::string& path,
                                                 const io::HeightReadOptions& reading,
                                                 const std::optional<PyramidOptions>& pyramid,
                                                 Progress& progress);

}  // namespace lode
