#include "lode/render/shading.h"

#include <algorithm>
#include <cmath>

#include "lode/render/sampling.h"

namespace lode {
namespace {

// Meant so that a matt surface that faces the viewer comes out close to its own colour.
constexpr Vec3f kSkyColor{{0.93f, 0.97f, 1.04f}};
constexpr Vec3f kKeyColor{{1.05f, 1.00f, 0.93f}};
constexpr float kSkyStrength = 0.62f;
constexpr float kKeyStrength = 0.80f;
constexpr float kSkyBelow = 0.55f;  // Of the sky straight up.
constexpr float kLampRadius = 0.12f;
constexpr float kHighlight = 0.07f;
constexpr float kHighlightPower = 36;
constexpr float kRim = 0.16f;

Vec3f product(const Vec3f& a, const Vec3f& b) { return {{a[0] * b[0], a[1] * b[1], a[2] * b[2]}}; }

float sky_at(float height) { return kSkyBelow + (1 - kSkyBelow) * (0.5f + 0.5f * height); }

}  // namespace

Lights::Lights(const CameraAxes& axes)
    : up_(to_vec3f(normalized(axes.up - axes.forward * 0.25))),
      key_(to_vec3f(normalized(axes.right * -0.55 + axes.up * 0.75 - axes.forward * 0.75))) {}

float Lights::mean_sky(const Vec3f& normal) const {
  // The mean of d·up over cosine-distributed d round n is (2/3) n·up.
  return sky_at(dot(normal, up_) * (2.0f / 3.0f));
}

float Lights::sky_share(const Vec3f& normal, const Vec3f& direction) const {
  return sky_at(dot(direction, up_)) / mean_sky(normal);
}

Vec3f Lights::sky_light(const SceneHit& hit, const Vec3f& view) const {
  const float edge = 1 - std::clamp(dot(hit.normal, view), 0.0f, 1.0f);
  const float rim = kRim * edge * edge * edge * (0.6f + 0.4f * dot(hit.normal, up_));
  const float mean = kSkyStrength * mean_sky(hit.normal);
  return product(hit.color, kSkyColor) * mean + kSkyColor * (rim * mean);
}

Vec3f Lights::key_light(const SceneHit& hit, const Vec3f& view) const {
  const float cosine = key_cosine(hit.normal);
  if (cosine <= 0) return {};
  const float half = std::max(0.0f, dot(hit.normal, normalized(key_ + view)));
  const float highlight = kHighlight * std::pow(half, kHighlightPower) * std::min(1.0f, 4 * cosine);
  return product(hit.color, kKeyColor) * (kKeyStrength * cosine) +
         kKeyColor * (kKeyStrength * highlight);
}

float Lights::key_cosine(const Vec3f& normal) const { return std::max(0.0f, dot(normal, key_)); }

Vec3f Lights::key_direction(float u, float v) const {
  return disc_direction(key_, kLampRadius, u, v);
}

Vec3f tone_map(const Vec3f& light) {
  constexpr float kKnee = 0.8f;
  const float top = std::max({light[0], light[1], light[2]});
  if (!(top > kKnee)) return light;
  const float excess = (top - kKnee) / (1 - kKnee);
  const float mapped = kKnee + (1 - kKnee) * (excess / (1 + excess));
  return light * (mapped / top);
}

}  // namespace lode
