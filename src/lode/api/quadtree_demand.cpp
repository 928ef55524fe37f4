#include "lode/api/quadtree_demand.h"

#include <array>

#include "lode/refine/surface_facts.h"

namespace lode {

using quaternary_triangulation::HalfSquare;
using quaternary_triangulation::QuaternaryTriangulation;
using squares::Square;
using surface_quadtree::SurfaceQuadtree;

namespace {

/// The ends of the diagonal from the lower left, then the upper left and the lower right.
std::array<LatticePoint, 4> corners_of(const Square& square) {
  const LatticePoint a{square.x(), square.y()};
  const LatticePoint c{a.x + square.side(), a.y + square.side()};
  return {a, c, LatticePoint{a.x, c.y}, LatticePoint{c.x, a.y}};
}

std::array<LatticePoint, 3> corners_of(const HalfSquare& half) {
  const auto all = corners_of(half.square);
  return {all[0], all[1], half.is_upper ? all[2] : all[3]};
}

}  // namespace

bool QuadtreeDemand::wants(std::span<const LatticePoint> corners, double error) const {
  SurfacePatch patch;
  for (const LatticePoint p : corners) {
    const Vec<double, 2> at = frame_.world(p.x, p.y);
    patch.add({{at[0], at[1], domain_.height(p.x, p.y)}});
  }
  const NodeFacts facts = patch.facts(error, {range_.lower, range_.upper});
  return demand_.touches(facts) && demand_(facts) > 0;
}

std::vector<Square> QuadtreeDemand::leaves(const SurfaceQuadtree& tree) const {
  return tree.leaves([&](const Square& square) {
    return wants(corners_of(square), static_cast<double>(tree.error(square)));
  });
}

std::vector<HalfSquare> QuadtreeDemand::leaves(const QuaternaryTriangulation& tree) const {
  return tree.leaves([&](const HalfSquare& half) {
    return wants(corners_of(half), static_cast<double>(tree.error(half)));
  });
}

}  // namespace lode
