#pragma once

#include "lode/core/box.h"

namespace lode::diamond {

/// Whether a box has a point, its sides included.
inline bool is_in_box(const Box3d& box, const Vec3d& p) {
  return p[0] >= box.lower[0] && p[1] >= box.lower[1] && p[2] >= box.lower[2] &&
         p[0] <= box.upper[0] && p[1] <= box.upper[1] && p[2] <= box.upper[2];
}

}  // namespace lode::diamond
