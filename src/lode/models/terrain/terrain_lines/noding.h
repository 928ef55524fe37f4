#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/lattice_point.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode::terrain_lines {

/// Lines of which any two meet at nodes only.
struct NodedLines {
  std::vector<LatticePoint> nodes;                  ///< Different; those that edges end at.
  std::vector<double> heights;                      ///< By node; NaN: its lines have none.
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< By numbers of nodes, none twice.
};

/// Rounds lines to a lattice so that they still meet at nodes only, by GEOS's snap rounding (J. D.
/// Hobby, "Practical segment intersection with finite precision output", Computational Geometry 13
/// (4), 1999): no line moves by more than the diagonal of half a cell. `lines`: columns, rows and
/// heights, which may be NaN; coordinates below 2^30 in size. New nodes get heights on the lines
/// that cross there; where these differ, one that is between them. Fails, with GEOS's reason, where
/// it has none.
[[nodiscard]] Result<NodedLines> node_lines(std::span<const std::vector<Vec3d>> lines);

}  // namespace lode::terrain_lines
