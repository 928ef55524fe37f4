#include "lode/core/regular_grid.h"

#include <algorithm>

namespace lode {

std::string_view name_of(Frame frame) {
  switch (frame) {
    case Frame::ras: return "RAS";
    case Frame::lps: return "LPS";
    case Frame::unknown: break;
  }
  return "unknown";
}

Mat3 RegularGrid::index_to_world_matrix() const {
  Mat3 m = direction;
  for (Vec3d& row : m.rows)
    for (std::size_t i = 0; i < 3; ++i) row[i] *= spacing[i];
  return m;
}

Vec3d RegularGrid::to_world(const Vec3d& index) const {
  return origin + index_to_world_matrix() * index;
}

Vec3d RegularGrid::to_index(const Vec3d& world) const {
  const Mat3 m = index_to_world_matrix();
  const Mat3 c = cofactors(m);
  const double inverse_determinant = 1.0 / determinant(m);
  const Vec3d d = world - origin;
  Vec3d index;
  for (std::size_t i = 0; i < 3; ++i) index[i] = dot(c.column(i), d) * inverse_determinant;
  return index;
}

bool RegularGrid::has_world_axes() const {
  for (const Vec3d& row : direction.rows)
    if (std::count(row.v.begin(), row.v.end(), 0.0) != 2) return false;
  return true;
}

Box3d RegularGrid::world_bounds() const {
  Box3d box{origin, origin};
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d index;
    for (std::size_t i = 0; i < 3; ++i)
      index[i] = ((corner >> i) & 1) != 0 ? static_cast<double>(dims[i] - 1) : 0.0;
    const Vec3d p = to_world(index);
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = std::min(box.lower[i], p[i]);
      box.upper[i] = std::max(box.upper[i], p[i]);
    }
  }
  return box;
}

}  // namespace lode
