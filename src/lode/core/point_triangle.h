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

/// Of a triangle that is long and thin, where products of edges leave the foot anywhere along it:
/// by its longest edge and what is across from that.
template <typename T>
[[nodiscard]] T squared_distance_to_thin_triangle(const Vec<T, 3>& p,
                                                  const std::array<Vec<T, 3>, 3>& t) {
  std::size_t first = 0;
  T longest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec<T, 3> edge = t[(i + 1) % 3] - t[i];
    if (!(dot(edge, edge) > longest)) continue;
    longest = dot(edge, edge);
    first = i;
  }
  const Vec<T, 3>& a = t[first];
  const Vec<T, 3> along = t[(first + 1) % 3] - a;
  const Vec<T, 3> third = t[(first + 2) % 3] - a;
  const T third_along = dot(third, along) / longest;
  const Vec<T, 3> across = third - along * third_along;
  const Vec<T, 3> q = p - a;
  const T x = dot(q, along) / longest;
  const Vec<T, 3> beside = q - along * x;
  const T r = dot(beside, across) / dot(across, across);
  const T s = x - r * third_along;
  const T edges =
      std::min({squared_distance_to_segment(p, a, along), squared_distance_to_segment(p, a, third),
                squared_distance_to_segment(p, a + along, third - along)});
  if (!(s >= 0 && r >= 0 && s + r <= 1)) return edges;
  const Vec<T, 3> d = beside - across * r;
  return std::min(edges, dot(d, d));
}

/// Squared distance from a point to a triangle, which may have zero area. That of a point of the
/// triangle that is computed with rounding errors, so it is never too small by more than those of
/// the last subtraction; nor is it, in doubles, much larger.
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
  // The sine between the edges, squared.
  constexpr T kThin = static_cast<T>(sizeof(T) == sizeof(double) ? 1e-6 : 0);
  if (area < kThin * uu * vv) return squared_distance_to_thin_triangle(p, t);
  if (s >= 0 && r >= 0 && area > 0 && s + r <= area) {
    const Vec<T, 3> d = q - u * (s / area) - v * (r / area);
    return dot(d, d);
  }
  return std::min({squared_distance_to_segment(p, t[0], u), squared_distance_to_segment(p, t[0], v),
                   squared_distance_to_segment(p, t[1], t[2] - t[1])});
}

}  // namespace lode
