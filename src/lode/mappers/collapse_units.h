#pragma once

#include <array>
#include <span>

#include "lode/core/surface.h"
#include "lode/core/vec.h"
#include "lode/mappers/surface_band.h"

namespace lode::simplification {

/// Brings edges of a surface to a length of about 1 for as long as this is there, so that no sum of
/// products of them leaves the range of float32. By a power of two, which rounds nothing but what
/// is below 1e-38 of an edge. The surface has a triangle, and outlives this.
class UnitEdges {
 public:
  explicit UnitEdges(Surface& surface);
  UnitEdges(const UnitEdges&) = delete;
  UnitEdges& operator=(const UnitEdges&) = delete;
  ~UnitEdges();

  [[nodiscard]] double to_units(double length) const;
  [[nodiscard]] double from_units(double length) const;

 private:
  void scale(int exponent);
  void multiply(float factor);

  Surface& surface_;
  int exponent_ = 0;
};

/// A band for positions that were brought to other units.
class ScaledBand final : public SurfaceBand {
 public:
  /// `unit`: of the positions, in those of `band`; a power of two.
  ScaledBand(const SurfaceBand& band, double unit) : band_(band), unit_(unit) {}

  [[nodiscard]] double limit() const override { return band_.limit(); }
  [[nodiscard]] Vec3d own_coordinates(const Vec3d& position) const override {
    return band_.own_coordinates(position * unit_);
  }
  [[nodiscard]] unsigned border_planes(const Vec3d& point) const override {
    return band_.border_planes(point);
  }
  [[nodiscard]] bool may_hold_fixed(const std::array<Vec3d, 4>& tetrahedron) const override {
    return band_.may_hold_fixed(tetrahedron);
  }
  [[nodiscard]] bool seems_within(const Vec3d& apex,
                                  std::span<const std::array<Vec3d, 2>> fan) const override {
    return band_.seems_within(apex, fan);
  }
  [[nodiscard]] double largest_deviation(const std::array<Vec3d, 3>& triangle) const override {
    return band_.largest_deviation(triangle);
  }

 private:
  const SurfaceBand& band_;
  double unit_;
};

}  // namespace lode::simplification
