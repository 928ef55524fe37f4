#pragma once

#include "lode/core/regular_grid.h"
#include "lode/core/surface.h"
#include "lode/mappers/lattice_key.h"

namespace lode {

/// How many steps along an axis of the grid a point may be off that is off by up to `distances`
/// along those of the world, whichever axis is the worst; of one sample along an axis it is none.
[[nodiscard]] double in_steps(const RegularGrid& grid, const Vec3d& distances);

/// How lattice coordinates become the float32 positions of a Surface, and how far vertices must
/// stay from lattice points so that rounding can neither merge two nor flip a triangle.
struct LatticeFrame {
  Vec3d
      surface_origin;   ///< Subtracted before rounding to float32; zero where that is exact enough.
  Vec3d origin;         ///< Position of lattice point 0, relative to surface_origin.
  Mat3 to_world;        ///< Columns: one lattice step along each axis.
  double margin = 0;    ///< Edge parameters lie in [margin, 1 - margin].
  double rounding = 0;  ///< A position's rounding error, in lattice steps.
  bool is_mirrored = false;

  /// Chooses the origin and the margin: in_steps() of 32 ulp of float32 at the largest coordinate
  /// along each axis, at most a quarter. (Only axes of their own matter: what is scaled along its
  /// axes is as manifold as before.) With world coordinates so large that this is more than 1/128,
  /// positions are taken relative to the lower corner of the bounds.
  [[nodiscard]] static LatticeFrame of(const RegularGrid& grid);

  [[nodiscard]] Vec3d position(const Vec3d& lattice) const { return origin + to_world * lattice; }
};

}  // namespace lode
