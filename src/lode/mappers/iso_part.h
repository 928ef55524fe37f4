#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "lode/mappers/lattice_frame.h"
#include "lode/mappers/lattice_key.h"

namespace lode {

/// Where a vertex of an isosurface comes from: the point at parameter t of a lattice edge.
struct EdgePoint {
  LatticeKey first = 0;  ///< The end with the smaller key; marked kTwin where it is one.
  LatticeKey second = 0;
  double t = 0;

  [[nodiscard]] LatticeKey doubled_midpoint() const { return first + second; }
  [[nodiscard]] Vec3d lattice_position() const {
    const Index3 a = to_point(first);
    const Index3 b = to_point(second);
    Vec3d p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = a[i] + t * (b[i] - a[i]);
    return p;
  }
};

/// Where the field, linear along the edge p – q from a to b, is the isovalue. The same edge gives
/// the same point, whichever end comes first.
[[nodiscard]] inline EdgePoint crossing(LatticeKey p, double a, LatticeKey q, double b,
                                        double isovalue) {
  if (p > q) {
    std::swap(p, q);
    std::swap(a, b);
  }
  return {p, q, (isovalue - a) / (b - a)};
}

/// What one part of the lattice (a brick, or everything coarser than bricks) contributes to an
/// isosurface: vertices on its edges and cells (triangles, or lines in 2D) between them.
template <int D>
struct IsoPart {
  std::vector<EdgePoint> points;  ///< The vertices.
  std::vector<std::array<std::uint32_t, static_cast<std::size_t>(D)>> cells;
  double largest_step = 0;  ///< Largest difference of values along a crossed edge.
  double largest_snap = 0;  ///< The same over vertices that the margin moved.

  /// Adds the vertex where the field, linear along the edge p – q from a to b, is the isovalue; its
  /// parameter is kept within [margin, 1 - margin]. twin: kTwin or 0.
  std::uint32_t add_point(LatticeKey p, double a, LatticeKey q, double b, double isovalue,
                          double margin, LatticeKey twin = 0) {
    EdgePoint point = crossing(p, a, q, b, isovalue);
    point.first |= twin;
    return add_point(point, b - a, margin);
  }
  /// The same of a point that is known but for the margin; `step`: the difference along its edge.
  std::uint32_t add_point(EdgePoint point, double step, double margin) {
    const double kept = std::clamp(point.t, margin, 1 - margin);
    step = std::abs(step);
    largest_step = std::max(largest_step, step);
    if (kept != point.t) largest_snap = std::max(largest_snap, step);
    point.t = kept;
    points.push_back(point);
    return static_cast<std::uint32_t>(points.size() - 1);
  }
};

}  // namespace lode
