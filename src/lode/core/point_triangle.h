#pragma once

#include <algorithm>
#include <array>

#include "lode/core/vec.h"

namespace lode {

/// Squared distance from a point to the segment from a to a + e.
template <typename T>
[[nodiscard]] T squared_distance_to_segment(const Vec<T, 3>& p, const Vec<T, 3>& a,
                                            const Vec<T, 3>& e) {
  const Vec<T, 3> q = p - a;
  const T along = dot(e, e);
  const T s = along > 0 ? std::clamp(dot(q, e) / along, T(0), T(1)) : T(0);
  const Vec<T, 3> d = q - e * s;
  return dot(d, d);
}

/// Squared distance from a point to a triangle, which may have zero area. That of a point of the
/// triangle that is computed with rounding errors, so it is never too small by more than those of
/// the last subtraction.
template <typename T>
[[nodiscard]] T squared_distance_to_triangle(const Vec<T, 3>& p,
                                             const std::array<Vec<T, 3>, 3>& t) {
  const Vec<T, 3> u = t[1] - t[0];
  const Vec<T, 3> v = t[2] - t[0];
  const Vec<T, 3> q = p - t[0];
  const T uu = dot(u, u);
  const T uv = dot(u, v);
  const T vv = dot(v, v);
  const T qu = dot(q, u);
  const T qv = dot(q, v);
  const T area = uu * vv - uv * uv;
  const T s = vv * qu - uv * qv;
  const T r = uu * qv - uv * qu;
  if (s >= 0 && r >= 0 && area > 0 && s + r <= area) {
    const Vec<T, 3> d = q - u * (s / area) - v * (r / area);
    return dot(d, d);
  }
  return std::min({squared_distance_to_segment(p, t[0], u), squared_distance_to_segment(p, t[0], v),
                   squared_distance_to_segment(p, t[1], t[2] - t[1])});
}

}  // namespace lode
