#include "lode/models/tetra_mt/fan.h"

#include <algorithm>
#include <cmath>

namespace lode::tetra_mt {

void StarLanes::fill(const Star& star, const std::array<Vec3d, Star::kMaxLink>& link,
                     const std::vector<float>& link_values, std::size_t n_fields) {
  double radius = 0;
  for (int i = 0; i < star.n_link; ++i)
    if (i != star.outside) {
      const Vec3d& p = link[static_cast<std::size_t>(i)];
      radius = std::max(radius, dot(p, p));
    }
  radius = std::sqrt(radius);
  const auto n_triangles = static_cast<std::size_t>(star.n_triangles);
  n = (n_triangles + kPadding - 1) / kPadding * kPadding;
  values.resize(n_fields);
  for (std::size_t i = 0; i < n; ++i) {
    const bool is_flat =
        i >= n_triangles || (star.outside >= 0 && star.has(static_cast<int>(i), star.outside));
    const auto t = is_flat ? std::array<std::uint8_t, 3>{} : star.triangles[i];
    const Vec3d zero;
    const Vec3d& a = is_flat ? zero : link[t[0]];
    const Vec3d& b = is_flat ? zero : link[t[1]];
    const Vec3d& c = is_flat ? zero : link[t[2]];
    const Vec3d plane = cross(c - a, b - a);
    heights[i] = dot(plane, a);
    slacks[i] = kFlat * length(plane) * radius;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      planes[axis][i] = plane[axis];
      corners[0][axis][i] = static_cast<float>(a[axis]);
      corners[1][axis][i] = static_cast<float>(b[axis]);
      corners[2][axis][i] = static_cast<float>(c[axis]);
    }
    for (std::size_t f = 0; f < n_fields; ++f)
      for (std::size_t k = 0; k < 3; ++k)
        values[f][k][i] = is_flat ? 0 : link_values[t[k] * n_fields + f];
  }
}

void clamp_weights(std::array<double, 3>& weights) {
  double sum = std::max(0.0, 1 - (weights[0] + weights[1] + weights[2]));
  for (double& w : weights) {
    w = std::max(w, 0.0);
    sum += w;
  }
  for (double& w : weights) w /= sum;
}

float Fan::error(const StarSamples& samples, std::size_t sample, std::size_t field,
                 std::size_t lane) const {
  const auto& g = gradients[field];
  const float rise = g[0][lane] * (samples.x[sample] - at[0]) +
                     g[1][lane] * (samples.y[sample] - at[1]) +
                     g[2][lane] * (samples.z[sample] - at[2]);
  return samples.values[sample * samples.n_fields + field] - (kept_value[field] + rise);
}

float Fan::distance(const StarSamples& samples, std::size_t sample, std::size_t field,
                    std::size_t lane) const {
  const auto& g = gradients[field];
  const float slope =
      std::sqrt(g[0][lane] * g[0][lane] + g[1][lane] * g[1][lane] + g[2][lane] * g[2][lane]);
  const float difference = std::abs(error(samples, sample, field, lane));
  const bool is_near = difference < kFarthest * slope;
  return samples.space_unit * (is_near ? difference / slope : difference == 0 ? 0 : kFarthest);
}

}  // namespace lode::tetra_mt
