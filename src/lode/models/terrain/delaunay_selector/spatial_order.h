#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/height_points.h"
#include "lode/delaunay/point_insertion.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/delaunay_selector/point_domain.h"

namespace lode::delaunay_selector {

/// Points and their domain renumbered along a curve that fills the plane (G. Morton, "A computer
/// oriented geodetic data base and a new technique in file sequencing", 1966), so that those of a
/// triangle are near each other in memory: selecting of 2 million points takes 1.8 s instead
/// of 3.2.
struct SpatialOrder {
  std::vector<LatticePoint> nodes;
  std::vector<double> heights;
  std::vector<std::uint32_t> triangle_of;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Of the domain, and so the lines.
  std::vector<std::array<std::uint32_t, 2>> lines;

  SpatialOrder(const HeightPoints& points, const PointDomain& domain);

  [[nodiscard]] delaunay::PointSamples samples() const { return {nodes, heights, triangle_of}; }
  /// The domain's triangles, cut along its lines.
  [[nodiscard]] delaunay::PointMesh mesh() const;
  /// The TIN of a mesh of these points, healed, with heights, its vertices in rows.
  [[nodiscard]] delaunay::Tin to_tin(const delaunay::PointMesh& mesh,
                                     delaunay::TinLinks links) const;
};

}  // namespace lode::delaunay_selector
