#pragma once

#include <array>
#include <cstdint>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"

namespace lode {

/// Pairs of triangles (lines) that meet where they should not.
struct SelfIntersectionReport {
  std::uint64_t n_simplices = 0;   ///< Looked at: those with zero area (length) are left out.
  std::uint64_t n_candidates = 0;  ///< Pairs whose boxes meet.
  std::uint64_t n_intersections = 0;
  std::array<std::uint32_t, 2> first{{0, 0}};  ///< The lowest such pair of indices.

  friend bool operator==(const SelfIntersectionReport&, const SelfIntersectionReport&) = default;
};

/// Finds all self-intersections of a well-formed surface, exactly for its float coordinates.
/// Simplices may meet at corners and edges with equal coordinates (so twins may touch), nowhere
/// else; two with all corners equal overlap. Contour lines are looked at along the coordinate axis
/// most perpendicular to their plane.
/// Fails when cancelled.
[[nodiscard]] Result<SelfIntersectionReport> check_self_intersections(const Surface& surface,
                                                                      Threads threads,
                                                                      Progress& progress);

}  // namespace lode
