#include "lode/api/opened_terrain.h"

#include <memory>
#include <new>
#include <utility>

#include "lode/api/files.h"
#include "lode/core/out_of_memory.h"

namespace lode {
namespace {

TerrainFacts facts_of(const TerrainPyramid& pyramid) {
  const PyramidInfo info = pyramid.describe_source();
  return {.frame = pyramid.frame(),
          .format = "LODE",
          .type = info.sample_type,
          .has_place = info.has_place,
          .n_missing = info.n_missing};
}

OpenedTerrain of_pyramid(TerrainPyramid pyramid) {
  Terrain terrain = pyramid.terrain();
  TerrainFacts facts = facts_of(pyramid);
  return {std::move(terrain), TerrainModel::delaunay_pyramid, std::move(facts), std::move(pyramid)};
}

}  // namespace

const char* name_of(TerrainModel model) {
  return model == TerrainModel::delaunay_selector ? "delaunay_selector" : "delaunay_pyramid";
}

TerrainFacts facts_of(const io::HeightRaster& raster) {
  return {.frame = raster.grid,
          .format = raster.format,
          .type = raster.type,
          .has_place = raster.has_place,
          .n_missing = raster.grid.n_missing()};
}

bool holds_terrain_model(const std::string& path) {
  return is_lode_path(path) && TerrainPyramid::is_model_of(path);
}

bool holds_terrain(const std::string& path) {
  return io::is_height_path(path) || holds_terrain_model(path);
}

Result<OpenedTerrain> open_terrain(const std::string& path, const io::HeightReadOptions& reading,
                                   const std::optional<PyramidOptions>& pyramid,
                                   Progress& progress) try {
  if (is_lode_path(path)) {
    LODE_TRY(TerrainPyramid opened, TerrainPyramid::open(path, progress));
    return of_pyramid(std::move(opened));
  }
  LODE_TRY(io::HeightRaster read, io::read_heights(path, reading, progress));
  if (pyramid) {
    PyramidOptions options = *pyramid;
    options.sample_type = read.type;
    options.has_place = read.has_place;
    auto built = TerrainPyramid::build(read.grid, options, progress);
    if (!built && !progress.is_cancelled()) return fail("{}: {}", path, built.error().message);
    if (!built) return built.error();
    return of_pyramid(*std::move(built));
  }
  const auto raster = std::make_shared<const io::HeightRaster>(std::move(read));
  return OpenedTerrain{Terrain(std::shared_ptr<const HeightGrid>(raster, &raster->grid)),
                       TerrainModel::delaunay_selector, facts_of(*raster)};
} catch (const std::bad_alloc&) {
  return out_of_memory("open the terrain", path);
}

}  // namespace lode
