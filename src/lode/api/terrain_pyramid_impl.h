#pragma once

#include "lode/api/terrain_pyramid.h"
#include "lode/models/terrain/delaunay_pyramid/persist.h"

namespace lode {

struct TerrainPyramid::Impl {
  delaunay_pyramid::Pyramid pyramid;
};

}  // namespace lode
