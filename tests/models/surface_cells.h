#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "lode/core/surface.h"

namespace lode {

/// Cells by their corners' positions, each from its least corner on, in order: equal for surfaces
/// that differ only in how things are numbered. Lines repeat their second end.
inline std::vector<std::array<Vec3f, 3>> cells_of(const Surface& surface) {
  std::vector<std::array<Vec3f, 3>> cells;
  for (const auto& t : surface.triangles) {
    std::array<Vec3f, 3> cell{surface.positions[t[0]], surface.positions[t[1]],
                              surface.positions[t[2]]};
    std::rotate(cell.begin(), std::min_element(cell.begin(), cell.end()), cell.end());
    cells.push_back(cell);
  }
  for (const auto& l : surface.lines)
    cells.push_back({surface.positions[l[0]], surface.positions[l[1]], surface.positions[l[1]]});
  std::sort(cells.begin(), cells.end());
  return cells;
}

}  // namespace lode
