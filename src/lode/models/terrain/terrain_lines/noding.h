#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/lattice_point.h"
#include "lode/core/place_line.h"
#include "lode/core/result.h"

namespace lode::terrain_lines {

/// Lines of which any two meet at nodes only.
struct NodedLines {
  std::vector<LatticePoint> nodes;                  ///< In rows, different.
  std::vector<double> own_heights;                  ///< By node: see LineToNode; NaN: none.
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< By numbers of nodes, sorted, none twice.
  std::vector<bool> is_own;                         ///< By edge: of a line with own heights.
  std::uint64_t n_unequal = 0;  ///< Nodes that lines with own heights reach at different ones,
  double largest_spread = 0;    ///< and by how much at most; also where a line meets itself.
};

struct LineToNode {
  PlaceLine places;              ///< Columns and rows below 2^30 in size, and heights.
  bool has_own_heights = false;  ///< Whatever is on it has those heights, too.
};

/// Rounds lines to a lattice so that they still meet at nodes only, by GEOS's snap rounding (J. D.
/// Hobby, "Practical segment intersection with finite precision output", Computational Geometry 13
/// (4), 1999): no line moves by more than the diagonal of half a cell. Nodes on lines with own
/// heights get those, where several cross their mean. Fails, with GEOS's reason, where it has none.
[[nodiscard]] Result<NodedLines> node_lines(std::span<const LineToNode> lines);

}  // namespace lode::terrain_lines
