#include "lode/core/surface.h"

namespace lode {

Vec3d Surface::world_position(std::uint32_t vertex) const {
  const Vec3f& p = positions[vertex];
  return {{origin[0] + static_cast<double>(p[0]), origin[1] + static_cast<double>(p[1]),
           origin[2] + static_cast<double>(p[2])}};
}

std::uint64_t Surface::n_bytes() const {
  std::uint64_t n = 0;
  for (const Attribute& attribute : attributes) n += capacity_bytes(attribute.values);
  return n + capacity_bytes(positions) + capacity_bytes(normals) + capacity_bytes(isovalues) +
         capacity_bytes(values) + capacity_bytes(origins) + capacity_bytes(errors) +
         capacity_bytes(regions) + capacity_bytes(patch_marks) + capacity_bytes(triangles) +
         capacity_bytes(lines);
}

void Surface::clear() {
  origin = {};
  positions.clear();
  normals.clear();
  isovalues.clear();
  values.clear();
  attributes.clear();
  origins.clear();
  errors.clear();
  region_names.clear();
  patches.clear();
  regions.clear();
  patch_marks.clear();
  triangles.clear();
  lines.clear();
}

void Surface::shrink_to_fit() {
  positions.shrink_to_fit();
  normals.shrink_to_fit();
  isovalues.shrink_to_fit();
  triangles.shrink_to_fit();
}

}  // namespace lode
