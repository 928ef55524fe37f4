#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "lode/core/vec.h"
#include "lode/models/tetra_mt/fan.h"
#include "lode/models/tetra_mt/star.h"
#include "lode/models/tetra_mt/value_distance.h"

namespace lode::tetra_mt {

/// The tetrahedra that come of a collapse, for one field: triangles of a star with the vertex that
/// is kept, or made.
struct ValuedFan {
  const Star& star;
  const Fan& fan;               ///< Says which triangles make none.
  std::span<const Vec3d> link;  ///< By link vertex.
  Vec3d apex;
  std::span<const double> values;  ///< By link vertex; anything of the one outside.
  double apex_value = 0;
};

/// How far the farthest corner of a fan is.
[[nodiscard]] inline double farthest_corner(const ValuedFan& of, const Vec3d& p) {
  double farthest = length(of.apex - p);
  for (std::size_t i = 0; i < static_cast<std::size_t>(of.star.n_triangles); ++i) {
    if (of.fan.gaps[i] != 0) continue;
    for (const std::uint8_t corner : of.star.triangles[i])
      farthest = std::max(farthest, length(of.link[corner] - p));
  }
  return farthest;
}

/// How far from `p` the fan has a value; where it has it nowhere, how far its farthest corner is.
/// `lane`: the triangle whose tetrahedron covers p.
[[nodiscard]] inline double distance_in_fan(const ValuedFan& of, std::size_t lane, double value,
                                            const Vec3d& p) {
  double least = std::numeric_limits<double>::infinity();
  const auto look_at = [&](std::size_t i) {
    if (of.fan.gaps[i] != 0) return;
    const auto& t = of.star.triangles[i];
    const std::array<double, 4> values{of.apex_value, of.values[t[0]], of.values[t[1]],
                                       of.values[t[2]]};
    const auto [low, high] = std::ranges::minmax(values);
    if (value < low || value > high) return;
    const std::array<Vec3d, 4> corners{of.apex, of.link[t[0]], of.link[t[1]], of.link[t[2]]};
    least = std::min(least, distance_to_value(corners, values, value, p));
  };
  look_at(lane);
  const auto n = static_cast<std::size_t>(of.star.n_triangles);
  for (std::size_t i = 0; i < n && least > 0; ++i)
    if (i != lane) look_at(i);
  return std::isfinite(least) ? least : farthest_corner(of, p);
}

}  // namespace lode::tetra_mt
