#include "lode/render/lens.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lode {

Lens::Lens(const Camera& camera, const Normalization& normalization, int width, int height)
    : axes_(axes_of(camera)),
      eye_(normalization.apply(camera.eye)),
      slope_per_px_(2 * std::tan(camera.field_of_view_deg * std::numbers::pi / 360) / height),
      center_x_(width / 2.0),
      center_y_(height / 2.0),
      target_distance_(length(normalization.apply(camera.target) - eye_)) {}

float Lens::pixel_size_at(const Vec3f& position) const {
  const Vec3d p{{double{position[0]}, double{position[1]}, double{position[2]}}};
  return static_cast<float>(slope_per_px_ * length(p - eye_));
}

std::optional<Lens::Ray> Lens::ray_through(double x, double y, double radius) const {
  const Vec3d direction =
      normalized(axes_.forward + axes_.right * ((x - center_x_) * slope_per_px_) +
                 axes_.up * ((center_y_ - y) * slope_per_px_));
  const double nearest = -dot(eye_, direction);
  const Vec3d miss = eye_ + direction * nearest;
  const double gap = radius * radius - dot(miss, miss);
  if (gap < 0) return std::nullopt;
  const double half_chord = std::sqrt(gap);
  if (nearest + half_chord < 0) return std::nullopt;
  const double start = std::max(0.0, nearest - half_chord);
  return Ray{to_vec3f(eye_ + direction * start), to_vec3f(direction)};
}

}  // namespace lode
