#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "lode/core/surface.h"

namespace lode::test {

inline Vec3f point(double x, double y, double z) {
  return {{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)}};
}

/// A torus of n × m quadrilaterals round the z axis, oriented outward.
inline Surface make_torus(std::uint32_t n, std::uint32_t m, double ring, double tube) {
  Surface surface;
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < m; ++j) {
      const double a = 2 * std::numbers::pi * i / n;
      const double b = 2 * std::numbers::pi * j / m;
      const double r = ring + tube * std::cos(b);
      surface.positions.push_back(point(r * std::cos(a), r * std::sin(a), tube * std::sin(b)));
      const std::uint32_t p = i * m + j;
      const std::uint32_t q = (i + 1) % n * m + j;
      const std::uint32_t r0 = i * m + (j + 1) % m;
      const std::uint32_t s = (i + 1) % n * m + (j + 1) % m;
      surface.triangles.push_back({p, q, s});
      surface.triangles.push_back({p, s, r0});
    }
  return surface;
}

/// A sphere of `rings` circles of latitude and two poles, oriented outward.
inline Surface make_sphere(std::uint32_t rings, double radius, const Vec3d& centre) {
  Surface surface;
  const std::uint32_t n = 2 * rings;
  const auto add = [&](double x, double y, double z) {
    surface.positions.push_back(
        point(centre[0] + radius * x, centre[1] + radius * y, centre[2] + radius * z));
  };
  add(0, 0, -1);
  add(0, 0, 1);
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const double a = std::numbers::pi * ((i + 1.0) / (rings + 1.0) - 0.5);
      const double b = 2 * std::numbers::pi * j / n;
      add(std::cos(a) * std::cos(b), std::cos(a) * std::sin(b), std::sin(a));
      const std::uint32_t p = 2 + i * n + j;
      const std::uint32_t q = 2 + i * n + (j + 1) % n;
      if (i == 0) surface.triangles.push_back({0, q, p});
      if (i + 1 == rings) {
        surface.triangles.push_back({1, p, q});
      } else {
        surface.triangles.push_back({p, q, q + n});
        surface.triangles.push_back({p, q + n, p + n});
      }
    }
  return surface;
}

/// A patch over [0, n]², height(x, y) high.
template <typename Height>
Surface make_patch(std::uint32_t n, const Height& height) {
  Surface surface;
  for (std::uint32_t y = 0; y <= n; ++y)
    for (std::uint32_t x = 0; x <= n; ++x) surface.positions.push_back(point(x, y, height(x, y)));
  for (std::uint32_t y = 0; y < n; ++y)
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t p = y * (n + 1) + x;
      surface.triangles.push_back({p, p + 1, p + n + 2});
      surface.triangles.push_back({p, p + n + 2, p + n + 1});
    }
  return surface;
}

/// A Möbius strip: a band of n quadrilaterals with half a twist.
inline Surface make_moebius_strip(std::uint32_t n) {
  Surface surface;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * i / n;
    for (const double side : {-0.3, 0.3}) {
      const double r = 1 + side * std::cos(a / 2);
      surface.positions.push_back(point(r * std::cos(a), r * std::sin(a), side * std::sin(a / 2)));
    }
    const bool is_last = i + 1 == n;
    const std::uint32_t p = 2 * i;
    const std::uint32_t q = is_last ? 1 : p + 2;
    const std::uint32_t s = is_last ? 0 : p + 3;
    surface.triangles.push_back({p, q, s});
    surface.triangles.push_back({p, s, p + 1});
  }
  return surface;
}

/// Adds a copy of `other`, with vertices of its own.
inline void append(Surface& surface, const Surface& other) {
  const auto base = static_cast<std::uint32_t>(surface.positions.size());
  surface.positions.insert(surface.positions.end(), other.positions.begin(), other.positions.end());
  for (const auto& t : other.triangles)
    surface.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

}  // namespace lode::test
