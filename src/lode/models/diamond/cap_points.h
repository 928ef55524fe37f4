#pragma once

#include <span>
#include <vector>

#include "lode/delaunay/triangulation.h"
#include "lode/mappers/lattice_frame.h"
#include "lode/models/diamond/border_polygon.h"

namespace lode::diamond {

/// A vertex of a cap: where it is in the lattice, and as written in the world.
struct CapVertex {
  Vec3d lattice;
  Vec3f world;
};

/// Whether some axis of the grid is none of the world's.
[[nodiscard]] bool is_oblique(const Mat3& to_world);

/// Coordinates in a border plane, seen from outside. Where the grid's axes are the world's, those
/// written, which are in the plane exactly; else those in the lattice, where what is straight there
/// is so exactly, although its rounded world coordinates are not. `rounding` is that of lattice
/// positions, per axis.
[[nodiscard]] std::vector<delaunay::Point> cap_points(const LatticeFrame& frame,
                                                      const Vec3d& rounding,
                                                      const BorderPlane& plane,
                                                      std::span<const CapVertex> vertices);

}  // namespace lode::diamond
