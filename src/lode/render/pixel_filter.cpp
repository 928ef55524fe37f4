#include "lode/render/pixel_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lode {
namespace {

constexpr float kSigmaPx = 2.2f;

std::array<float, kFilterRadius + 1> make_falloff() {
  std::array<float, kFilterRadius + 1> weights{};
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const float distance = static_cast<float>(i) / kSigmaPx;
    weights[i] = std::exp(-0.5f * distance * distance);
  }
  return weights;
}

// 0 across creases and between separate pieces, 1 on a plane. Sums over samples, not unit
// vectors and points, go in: both are divided by their coverage.
float likeness(const PixelData& a, const Vec3f& a_normal, const Vec3f& a_position,
               const PixelData& b, float pixel_size) {
  const float cosine = dot(a_normal, b.normal) / std::max(length(b.normal), 1e-12f);
  if (cosine < 0.7f) return 0;
  const Vec3f step = b.position * (1 / b.sky_coverage) - a_position;
  const float off_plane = std::abs(dot(step, a_normal)) / (2.5f * pixel_size);
  const float c2 = cosine * cosine;
  const float c8 = c2 * c2 * c2 * c2;
  return c8 * c8 * std::max(0.0f, 1 - off_plane) * std::min(a.sky_coverage, b.sky_coverage);
}

float ratio_or(float open, float whole, float otherwise) {
  return whole > 1e-9f ? open / whole : otherwise;
}

}  // namespace

Visibility smooth_visibility(const PixelRows& rows, int x, int y, int y_begin, int y_end,
                             float pixel_size) {
  static const std::array<float, kFilterRadius + 1> kFalloff = make_falloff();
  const PixelData& center = rows.at(x, y);
  if (center.sky_coverage <= 0) return {};
  const Vec3f normal = normalized(center.normal);
  const Vec3f position = center.position * (1 / center.sky_coverage);
  float sky_open = 0;
  float sky_whole = 0;
  float key_open = 0;
  float key_whole = 0;
  for (int v = std::max(y - kFilterRadius, y_begin); v <= std::min(y + kFilterRadius, y_end - 1);
       ++v) {
    for (int u = std::max(x - kFilterRadius, 0); u <= std::min(x + kFilterRadius, rows.width() - 1);
         ++u) {
      const PixelData& other = rows.at(u, v);
      if (other.sky_coverage <= 0) continue;
      const bool is_center = u == x && v == y;
      const float weight = kFalloff[static_cast<std::size_t>(std::abs(u - x))] *
                           kFalloff[static_cast<std::size_t>(std::abs(v - y))] *
                           (is_center ? 1 : likeness(center, normal, position, other, pixel_size));
      sky_open += weight * other.sky_open;
      sky_whole += weight * other.sky_coverage;
      key_open += weight * other.key_open;
      key_whole += weight * other.key_weight;
    }
  }
  return {.sky = ratio_or(sky_open, sky_whole, 1), .key = ratio_or(key_open, key_whole, 1)};
}

}  // namespace lode
