#pragma once

#include "lode/api/built_terrain.h"
#include "lode/models/terrain/insertions/persist.h"

namespace lode {

struct BuiltTerrain::Impl {
  insertions::LevelledHistory levelled;
};

/// Of one of kBuiltTerrainModels; an implicit pyramid has all samples, whatever max_error.
[[nodiscard]] Result<insertions::History> build_insertions(const HeightGrid& grid,
                                                           TerrainModel model, double max_error,
                                                           Progress& progress);

}  // namespace lode
