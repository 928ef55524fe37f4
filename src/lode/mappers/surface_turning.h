#pragma once

#include <cstdint>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"

namespace lode {

/// Which way the closed pieces of a surface of triangles face: of one that nowhere passes through
/// itself the signed volume says so, and no movement that keeps it so changes that.
struct PieceFacing {
  std::uint64_t n_outward = 0;  ///< Triangles turn left seen from outside.
  std::uint64_t n_inward = 0;
  std::uint64_t n_flat = 0;  ///< Of a volume that rounding may have made.
  std::uint64_t n_open = 0;
};
[[nodiscard]] PieceFacing facing_of(const Surface& surface, Threads threads);

/// Which way a surface faces, held against another near it: each triangle against the one of the
/// other that is nearest to its middle, which in noise need not be the one it came from.
struct NearFacing {
  /// Whether all of it has an area of a hundred reaches squared, or more. Of what is smaller, and
  /// may be off by a reach, shares say nothing.
  bool is_large = false;
  double share_turned = 0;         ///< Of the area, facing another way.
  std::uint64_t n_large_open = 0;  ///< Open pieces that are large;
  std::uint64_t n_turned = 0;      ///< of them, those of which three quarters face another way.
};

/// `reach`: about how far the surfaces are from each other, world units, > 0. Nothing where either
/// is empty. Fails when cancelled.
[[nodiscard]] Result<NearFacing> hold_against(const Surface& surface, const Surface& other,
                                              double reach, Threads threads,
                                              const Progress& progress);

}  // namespace lode
