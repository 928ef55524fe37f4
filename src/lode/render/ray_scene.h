#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/render/surface_colors.h"

namespace lode {

/// Maps world coordinates to a ball of radius 1 round 0, in double, so that rays and vertices
/// keep float accuracy whatever the data's scale and distance from the world's origin.
struct Normalization {
  Vec3d center{{0, 0, 0}};
  double scale = 1;

  [[nodiscard]] Vec3d apply(const Vec3d& world) const { return (world - center) * scale; }
};
[[nodiscard]] inline Vec3f to_vec3f(const Vec3d& a) {
  return {{static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2])}};
}
[[nodiscard]] Normalization normalization_of(const Box3d& box);

/// Where a ray met the scene, normalised coordinates.
struct SceneHit {
  Vec3f position;
  Vec3f normal;            ///< Interpolated, unit length, on the side of the viewer.
  Vec3f geometric_normal;  ///< Of the flat triangle, unit length, on the side of the viewer.
  Vec3f lifted;            ///< Where shadow and sky rays may start without meeting the triangle.
  Vec3f color;             ///< Linear light.
  bool is_line = false;    ///< Drawn flat: no light falls on contour lines.
};

/// Lines from a vertex to itself are balls, of so many radii of lines.
inline constexpr double kDotRadius = 2.5;

struct SceneOptions {
  Normalization normalization;
  double line_radius = 0.001;  ///< Normalised units.
  Threads threads;
};

/// A surface made ready for rays. Refers to the surface and the colours, which must outlive it.
/// Const members may be called from any thread.
class RayScene {
 public:
  /// Fails on indices beyond the vertices, attribute arrays of the wrong length, non-finite
  /// positions, and what Embree reports (memory).
  [[nodiscard]] static Result<RayScene> build(const Surface& surface, const SurfaceColors& colors,
                                              const SceneOptions& options, Progress& progress);

  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;
  ~RayScene();

  [[nodiscard]] std::optional<SceneHit> intersect(const Vec3f& origin,
                                                  const Vec3f& direction) const;
  [[nodiscard]] bool is_occluded(const Vec3f& origin, const Vec3f& direction, float distance) const;

 private:
  class Impl;
  explicit RayScene(std::unique_ptr<const Impl> impl);
  std::unique_ptr<const Impl> impl_;
};

}  // namespace lode
