#include "lode/core/surface.h"

namespace lode {

Vec3d Surface::world_position(std::uint32_t vertex) const {
  const Vec3f& p = positions[vertex];
  return {{origin[0] + static_cast<double>(p[0]), origin[1] + static_cast<double>(p[1]),
           origin[2] + static_cast<double>(p[2])}};
}

void Surface::clear() {
  origin = {};
  positions.clear();
  normals.clear();
  isovalues.clear();
  values.clear();
  origins.clear();
  errors.clear();
  triangles.clear();
  lines.clear();
}

}  // namespace lode
