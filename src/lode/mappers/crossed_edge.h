#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "lode/core/vec.h"

namespace lode {

/// Names an edge of a mesh by its ends, whichever comes first.
[[nodiscard]] inline std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

/// Where an edge's values cross an isovalue, from 0 at its first end to 1: at least `margin` (world
/// units) away from both ends, or a quarter of the edge.
[[nodiscard]] inline double crossing_of(double isovalue, double first, double second,
                                        const Vec3d& edge, double margin) {
  const double least = std::min(0.25, margin / length(edge));
  const double rise = second - first;
  // Halves of values so far apart that their difference is no number are exact.
  const double t = std::isfinite(rise) ? (isovalue - first) / rise
                                       : (isovalue / 2 - first / 2) / (second / 2 - first / 2);
  return std::clamp(t, least, 1 - least);
}

[[nodiscard]] inline Vec3f narrowed(const Vec3d& p) {
  return {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
}

}  // namespace lode
