#pragma once

#include <array>
#include <vector>

#include "lode/delaunay/lattice.h"
#include "lode/models/terrain/insertions/box_tree.h"
#include "lode/models/terrain/insertions/history.h"

namespace lode::insertions {

/// What hides vertices from triangles of a constrained Delaunay triangulation: edges of the base
/// that have nothing behind them, or are fixed.
class FixedEdges {
 public:
  /// Of a history's base.
  explicit FixedEdges(const History& base);

  /// Whether one of them lies between a triangle and a vertex that is in its circle. Where no
  /// vertex that the triangle sees was in the circle before, all of the triangle sees the new one,
  /// or nothing: an end of an edge that hides it from a part would be seen, and in the circle. So
  /// one way from within the triangle is tried. Exactly.
  [[nodiscard]] bool hide(const delaunay::LatticeCorners& triangle, delaunay::LatticePoint p) const;

 private:
  struct Edge {
    delaunay::LatticePoint from;
    delaunay::LatticePoint to;
  };

  std::vector<Edge> edges_;
  BoxTree boxes_;
};

}  // namespace lode::insertions
