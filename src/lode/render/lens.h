#pragma once

#include <optional>

#include "lode/core/vec.h"
#include "lode/render/camera.h"
#include "lode/render/ray_scene.h"

namespace lode {

/// Turns points of a picture into rays, in normalised coordinates.
class Lens {
 public:
  /// Precondition: check_camera(camera) holds. `width` and `height` in pixels.
  Lens(const Camera& camera, const Normalization& normalization, int width, int height);

  [[nodiscard]] const CameraAxes& axes() const { return axes_; }
  /// The distance of neighbouring pixels at the camera's target.
  [[nodiscard]] double pixel_size() const { return slope_per_px_ * target_distance_; }
  /// The same at another place.
  [[nodiscard]] float pixel_size_at(const Vec3f& position) const;

  [[nodiscard]] const Vec3d& eye() const { return eye_; }

  /// How far right and up a ray goes for each unit that it goes forward.
  struct Slopes {
    double right;
    double up;
  };
  /// Of the ray through a point of the picture (pixels from its upper left corner).
  [[nodiscard]] Slopes slopes_at(double x, double y) const {
    return {(x - center_x_) * slope_per_px_, (center_y_ - y) * slope_per_px_};
  }
  struct Point {
    double x;
    double y;
  };
  /// The other way round.
  [[nodiscard]] Point point_at(const Slopes& slopes) const {
    return {center_x_ + slopes.right / slope_per_px_, center_y_ - slopes.up / slope_per_px_};
  }

  struct Ray {
    Vec3f origin;
    Vec3f direction;
  };
  /// The ray through a point of the picture (pixels from its upper left corner), or nothing where
  /// it misses the ball of `radius` round 0 that holds the scene. Rays start where they enter the
  /// ball, so a far eye costs no accuracy.
  [[nodiscard]] std::optional<Ray> ray_through(double x, double y, double radius) const;

 private:
  CameraAxes axes_;
  Vec3d eye_;
  double slope_per_px_;
  double center_x_;
  double center_y_;
  double target_distance_;
};

}  // namespace lode
