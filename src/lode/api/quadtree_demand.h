#pragma once

#include <span>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/models/terrain/quaternary_triangulation/quaternary_triangulation.h"
#include "lode/models/terrain/surface_quadtree/surface_quadtree.h"
#include "lode/refine/demand.h"

namespace lode {

/// A demand on the squares and triangles of a model with gaps, whose tolerance may vary.
class QuadtreeDemand {
 public:
  /// The domain's samples, the demand and the frame outlive it; `range`: of all heights.
  QuadtreeDemand(const squares::SquareDomain& domain, const HeightFrame& frame,
                 const HeightRange& range, const Demand& demand)
      : domain_(domain), frame_(frame), range_(range), demand_(demand) {}

  /// Whether a polygon between samples, or a sample, may not err so.
  [[nodiscard]] bool wants(std::span<const LatticePoint> corners, double error) const;
  /// The highest squares, and triangles, that it does not want split.
  [[nodiscard]] std::vector<squares::Square> leaves(
      const surface_quadtree::SurfaceQuadtree& tree) const;
  [[nodiscard]] std::vector<quaternary_triangulation::HalfSquare> leaves(
      const quaternary_triangulation::QuaternaryTriangulation& tree) const;

 private:
  const squares::SquareDomain& domain_;
  const HeightFrame& frame_;
  HeightRange range_;
  const Demand& demand_;
};

}  // namespace lode
