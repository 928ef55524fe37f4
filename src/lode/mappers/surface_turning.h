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

/// The share of a surface's open pieces, by area, that face another way than the triangle of
/// `other` that is nearest to each triangle's middle; 0 where there are no such pieces, or `other`
/// is empty. `reach`: about how far the surfaces are from each other, world units, > 0. Fails when
/// cancelled.
[[nodiscard]] Result<double> share_turned(const Surface& surface, const Surface& other,
                                          double reach, Threads threads, const Progress& progress);

}  // namespace lode
