#pragma once

#include <array>

#include "lode/core/vec.h"
#include "lode/render/camera.h"
#include "lode/render/ray_scene.h"

namespace lode {

/// A sky, brighter above, and a soft key lamp over the viewer's left shoulder. Both turn with
/// the camera, so that every view of a surface is lit well.
class Lights {
 public:
  explicit Lights(const CameraAxes& axes);

  /// How much of the sky's light a sky ray brings, relative to the mean over all sky rays.
  [[nodiscard]] float sky_share(const Vec3f& normal, const Vec3f& direction) const;
  /// Light towards the viewer from the unobstructed sky, rim included.
  [[nodiscard]] Vec3f sky_light(const SceneHit& hit, const Vec3f& view) const;
  /// Light towards the viewer from the unobstructed lamp, highlight included.
  [[nodiscard]] Vec3f key_light(const SceneHit& hit, const Vec3f& view) const;
  /// Cosine between the normal and the lamp's centre; 0 on the far side.
  [[nodiscard]] float key_cosine(const Vec3f& normal) const;
  /// A direction to a point of the lamp; u, v uniform in [0, 1).
  [[nodiscard]] Vec3f key_direction(float u, float v) const;

 private:
  [[nodiscard]] float mean_sky(const Vec3f& normal) const;

  Vec3f up_;
  Vec3f key_;
};

/// Compresses light above 0.8 so that highlights keep their colour and never clip hard.
[[nodiscard]] Vec3f tone_map(const Vec3f& light);

}  // namespace lode
