#pragma once

#include "lode/api/built_terrain.h"
#include "lode/models/terrain/insertions/persist.h"

namespace lode {

struct BuiltTerrain::Impl {
  insertions::LevelledHistory levelled;
};

}  // namespace lode
