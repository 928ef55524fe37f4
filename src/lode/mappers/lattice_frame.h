#pragma once

#include "lode/core/regular_grid.h"
#include "lode/core/surface.h"
#include "lode/mappers/lattice_key.h"

namespace lode {

/// The smallest spacing of axes along which there are several samples, if there are any.
[[nodiscard]] double least_step(const RegularGrid& grid);

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

  /// Chooses the origin and the margin: 16 ulp of float32 at the largest coordinate, over
  /// least_step(). With world coordinates so large that this is more than 1/256 of a step,
  /// positions are taken relative to the lower corner of the bounds.
  [[nodiscard]] static LatticeFrame of(const RegularGrid& grid);

  [[nodiscard]] Vec3d position(const Vec3d& lattice) const { return origin + to_world * lattice; }
};

}  // namespace lode
