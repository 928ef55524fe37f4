#pragma once

#include <array>
#include <span>

#include "lode/core/vec.h"

namespace lode {

/// The band {|F - c| <= E} round a level set, which a surface may be moved in. Points come in the
/// band's own coordinates. From many threads at once.
class SurfaceBand {
 public:
  SurfaceBand() = default;
  SurfaceBand(const SurfaceBand&) = delete;
  SurfaceBand& operator=(const SurfaceBand&) = delete;
  virtual ~SurfaceBand() = default;

  /// E, in field units.
  [[nodiscard]] virtual double limit() const = 0;
  /// Own coordinates of a position as surfaces have them, relative to their origin: affine, but
  /// that what rounding put beside the domain's border comes to be on it.
  [[nodiscard]] virtual Vec3d own_coordinates(const Vec3d& position) const = 0;
  /// The planes of the domain's outer border that a point lies in, a bit each.
  [[nodiscard]] virtual unsigned border_planes(const Vec3d& point) const = 0;
  /// Whether a sample outside the band lies in a tetrahedron, its border included, flat ones too;
  /// true where rounding leaves it open. Every piece of {F > c + E} and of {F < c - E} has such a
  /// sample.
  [[nodiscard]] virtual bool may_hold_fixed(const std::array<Vec3d, 4>& tetrahedron) const = 0;
  /// Whether the triangles from `apex` to the edges of `fan` seem to lie in the band: by some of
  /// their points, but for those on the fan's edges.
  [[nodiscard]] virtual bool seems_within(const Vec3d& apex,
                                          std::span<const std::array<Vec3d, 2>> fan) const = 0;
  /// No point of a triangle has a larger |F - c|, rounded up: E where samples alone say that it is
  /// within the band, infinite where it leaves the domain.
  [[nodiscard]] virtual double largest_deviation(const std::array<Vec3d, 3>& triangle) const = 0;
};

}  // namespace lode
