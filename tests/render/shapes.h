#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "lode/core/surface.h"

namespace lode::test {

/// A closed surface over a grid of angles: `point(u, v)`, both 0..1, wraps in u and, where
/// `point` does, in v.
template <typename Point>
Surface parametric_surface(std::uint32_t n_u, std::uint32_t n_v, Point point) {
  Surface surface;
  for (std::uint32_t j = 0; j <= n_v; ++j) {
    for (std::uint32_t i = 0; i <= n_u; ++i) {
      surface.positions.push_back(
          point(static_cast<double>(i) / n_u, static_cast<double>(j) / n_v));
    }
  }
  for (std::uint32_t j = 0; j < n_v; ++j) {
    for (std::uint32_t i = 0; i < n_u; ++i) {
      const std::uint32_t a = j * (n_u + 1) + i;
      const std::uint32_t b = a + n_u + 1;
      surface.triangles.push_back({a, a + 1, b});
      surface.triangles.push_back({a + 1, b + 1, b});
    }
  }
  return surface;
}

inline Vec3f to_float(const Vec3d& a) {
  return {{static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2])}};
}

inline Surface make_sphere(const Vec3d& center, double radius, std::uint32_t n = 128) {
  return parametric_surface(2 * n, n, [&](double u, double v) {
    const double phi = 2 * std::numbers::pi * u;
    const double theta = std::numbers::pi * v;
    return to_float(center + Vec3d{{std::sin(theta) * std::cos(phi),
                                    std::sin(theta) * std::sin(phi), std::cos(theta)}} *
                                 radius);
  });
}

inline Surface make_torus(double major, double minor, std::uint32_t n = 96) {
  return parametric_surface(2 * n, n, [&](double u, double v) {
    const double phi = 2 * std::numbers::pi * u;
    const double psi = 2 * std::numbers::pi * v;
    const double r = major + minor * std::cos(psi);
    return to_float({{r * std::cos(phi), r * std::sin(phi), minor * std::sin(psi)}});
  });
}

}  // namespace lode::test
