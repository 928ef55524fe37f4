#pragma once

#include <array>

#include "lode/models/terrain/restricted_quadtree/restricted_quadtree.h"

namespace lode::restricted_quadtree {

using delaunay::LatticePoint;

/// visit(a, b, centre) for each triangle of a pattern, which turn left, side by side.
template <typename Visit>
void visit_pattern(const Square& square, SideMask midpoints, const Visit& visit) {
  const std::int32_t side = square.side();
  const std::int32_t half = side / 2;
  const LatticePoint o{square.x(), square.y()};
  const std::array<LatticePoint, 4> corners{
      o, {o.x + side, o.y}, {o.x + side, o.y + side}, {o.x, o.y + side}};
  const LatticePoint centre{o.x + half, o.y + half};
  for (std::size_t i = 0; i < 4; ++i) {
    const LatticePoint a = corners[i];
    const LatticePoint b = corners[(i + 1) % 4];
    if ((midpoints >> i & 1) == 0) {
      visit(a, b, centre);
      continue;
    }
    const LatticePoint middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
    visit(a, middle, centre);
    visit(middle, b, centre);
  }
}

}  // namespace lode::restricted_quadtree
