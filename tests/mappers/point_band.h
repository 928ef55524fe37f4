#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "lode/core/surface.h"
#include "lode/mappers/surface_band.h"

namespace lode::test {

inline double volume6(const std::array<Vec3d, 4>& t) {
  return dot(cross(t[1] - t[0], t[2] - t[0]), t[3] - t[0]);
}

/// A band that only some points are outside of, and where triangles fail the proof by chance, so
/// that much is taken back.
class PointBand final : public SurfaceBand {
 public:
  PointBand(std::vector<Vec3d> points, unsigned failing_percent)
      : points_(std::move(points)), failing_percent_(failing_percent) {}

  [[nodiscard]] double limit() const override { return 1; }
  [[nodiscard]] Vec3d own_coordinates(const Vec3d& position) const override { return position; }
  [[nodiscard]] unsigned border_planes(const Vec3d& /*point*/) const override { return 0; }
  [[nodiscard]] bool may_hold_fixed(const std::array<Vec3d, 4>& tetrahedron) const override {
    const double all = std::abs(volume6(tetrahedron));
    return std::ranges::any_of(points_, [&](const Vec3d& p) {
      double parts = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        auto part = tetrahedron;
        part[k] = p;
        parts += std::abs(volume6(part));
      }
      return parts <= all + 1e-6;
    });
  }
  [[nodiscard]] bool seems_within(const Vec3d& /*apex*/,
                                  std::span<const std::array<Vec3d, 2>> /*fan*/) const override {
    return true;
  }
  [[nodiscard]] double largest_deviation(const std::array<Vec3d, 3>& triangle) const override {
    std::uint64_t hash = 1;
    for (const Vec3d& p : triangle)
      for (const double x : p.v)
        hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x9E3779B97F4A7C15U;
    return (hash >> 40U) % 100 < failing_percent_ ? 2 : 0;
  }

 private:
  std::vector<Vec3d> points_;
  unsigned failing_percent_;
};

/// How often a closed surface goes round a point, by solid angles.
inline long winding(const Surface& surface, const Vec3d& p) {
  double sum = 0;
  for (const auto& t : surface.triangles) {
    const Vec3d a = widened(surface.positions[t[0]]) - p;
    const Vec3d b = widened(surface.positions[t[1]]) - p;
    const Vec3d c = widened(surface.positions[t[2]]) - p;
    sum += 2 * std::atan2(dot(a, cross(b, c)), length(a) * length(b) * length(c) +
                                                   dot(a, b) * length(c) + dot(b, c) * length(a) +
                                                   dot(c, a) * length(b));
  }
  return std::lround(sum / (4 * std::numbers::pi));
}

}  // namespace lode::test
