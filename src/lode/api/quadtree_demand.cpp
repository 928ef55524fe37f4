#include "lode/api/quadtree_demand.h"

#include <array>
#include <span>

#include "lode/refine/surface_facts.h"

namespace lode {

using quaternary_triangulation::HalfSquare;
using quaternary_triangulation::QuaternaryTriangulation;
using squares::Square;
using squares::SquareDomain;
using surface_quadtree::SurfaceQuadtree;

namespace {

/// What a demand sees of a polygon between samples: its error, and where it is in the world.
NodeFacts facts_of(const SquareDomain& domain, const HeightFrame& frame, const HeightRange& range,
                   std::span<const LatticePoint> corners, double error) {
  SurfacePatch patch;
  for (const LatticePoint p : corners) {
    const Vec<double, 2> at = frame.world(p.x, p.y);
    patch.add({{at[0], at[1], domain.height(p.x, p.y)}});
  }
  return patch.facts(error, {range.lower, range.upper});
}

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

bool wants(const Demand& demand, const NodeFacts& facts) {
  return demand.touches(facts) && demand(facts) > 0;
}

}  // namespace

delaunay::Tin tin_of_demand(const SurfaceQuadtree& tree, const HeightFrame& frame,
                            const HeightRange& range, const Demand& demand) {
  return to_tin(tree, tree.leaves([&](const Square& square) {
    return wants(demand, facts_of(tree.domain(), frame, range, corners_of(square),
                                  static_cast<double>(tree.error(square))));
  }));
}

delaunay::Tin tin_of_demand(const QuaternaryTriangulation& tree, const HeightFrame& frame,
                            const HeightRange& range, const Demand& demand) {
  return to_tin(tree, tree.leaves([&](const HalfSquare& triangle) {
    return wants(demand, facts_of(tree.domain(), frame, range, corners_of(triangle),
                                  static_cast<double>(tree.error(triangle))));
  }));
}

}  // namespace lode
