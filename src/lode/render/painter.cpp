#include "lode/render/painter.h"

#include <algorithm>
#include <cmath>

namespace lode {
namespace {

constexpr int kSkyRaysPerSample = 2;
constexpr float kSkyReach = 0.6f;      // Normalised: how far away a thing may be and still darken.
constexpr float kReflectance = 0.45f;  // Of the walls of a hollow: light that bounces back out.
constexpr float kPixelFilterRadius = 0.8f;
constexpr int kSampleTile = 16;

}  // namespace

Lens::Point sample_point(int x, int y, std::uint32_t i, int samples_per_pixel) {
  if (samples_per_pixel == 1) return {x + 0.5, y + 0.5};
  const PixelSequence points(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), 0);
  const std::array<float, 3> u = points.at(i);
  return {x + 0.5 + double{tent_offset(u[0], kPixelFilterRadius)},
          y + 0.5 + double{tent_offset(u[1], kPixelFilterRadius)}};
}

float Painter::open_sky(const SceneHit& hit, const PixelSequence& sky, std::uint32_t sample) const {
  if (options_.ambient_occlusion <= 0) return 1;
  float open = 0;
  for (std::uint32_t i = 0; i < kSkyRaysPerSample; ++i) {
    const std::array<float, 3> u = sky.at(sample * kSkyRaysPerSample + i);
    Vec3f direction = cosine_direction(hit.normal, u[0], u[1]);
    const float share = lights_.sky_share(hit.normal, direction);
    // Below the flat triangle but above the smooth surface: mirror it up, for the triangle's
    // own plane must not darken it.
    const float height = dot(direction, hit.geometric_normal);
    if (height < 0) direction = direction - hit.geometric_normal * (2 * height);
    // Random reaches make far things darken less, linearly, at no cost.
    if (!scene_.is_occluded(hit.lifted, direction, kSkyReach * u[2])) open += share;
  }
  return open / kSkyRaysPerSample;
}

void Painter::add_lit(PixelData& pixel, const SceneHit& hit, const Vec3f& view,
                      const PixelSequence& sky, const std::array<float, 3>& lamp,
                      std::uint32_t sample) const {
  pixel.sky = pixel.sky + lights_.sky_light(hit, view);
  pixel.key = pixel.key + lights_.key_light(hit, view);
  pixel.normal = pixel.normal + hit.normal;
  pixel.position = pixel.position + hit.position;
  pixel.sky_coverage += 1;
  pixel.sky_open += open_sky(hit, sky, sample);
  const float cosine = lights_.key_cosine(hit.normal);
  if (cosine <= 0) return;
  pixel.key_weight += cosine;
  const bool is_shaded = options_.shadow > 0 &&
                         scene_.is_occluded(hit.lifted, lights_.key_direction(lamp[0], lamp[1]), 4);
  if (!is_shaded) pixel.key_open += cosine;
}

PixelData Painter::sample_pixel(int x, int y) const {
  const auto column = static_cast<std::uint32_t>(x);
  const auto row = static_cast<std::uint32_t>(y);
  const PixelSequence lamp_points(column, row, 1);
  const PixelSequence sky_points(column, row, 2);
  const auto n = static_cast<std::uint32_t>(options_.samples_per_pixel);
  PixelData pixel{};
  for (std::uint32_t i = 0; i < n; ++i) {
    const Lens::Point point = sample_point(x, y, i, options_.samples_per_pixel);
    const auto ray = lens_.ray_through(point.x, point.y, radius_);
    if (!ray) continue;
    const auto hit = scene_.intersect(ray->origin, ray->direction);
    if (!hit) continue;
    pixel.coverage += 1;
    if (hit->is_line) {
      pixel.flat = pixel.flat + hit->color;
    } else {
      add_lit(pixel, *hit, ray->direction * -1.0f, sky_points, lamp_points.at(i), i);
    }
  }
  const float share = 1 / static_cast<float>(n);
  for (Vec3f* v : {&pixel.flat, &pixel.sky, &pixel.key, &pixel.normal, &pixel.position}) {
    *v = *v * share;
  }
  for (float* s : {&pixel.coverage, &pixel.sky_coverage, &pixel.sky_open, &pixel.key_weight,
                   &pixel.key_open}) {
    *s *= share;
  }
  return pixel;
}

Color background_at(const RenderOptions& options, int y) {
  const float f = (static_cast<float>(y) + 0.5f) / static_cast<float>(options.height);
  const auto blend = [f](std::uint8_t a, std::uint8_t b) {
    const float from = static_cast<float>(a);
    return static_cast<std::uint8_t>(std::lround(from + (static_cast<float>(b) - from) * f));
  };
  const Color& top = options.background.top;
  const Color& bottom = options.background.bottom;
  return {blend(top.r, bottom.r), blend(top.g, bottom.g), blend(top.b, bottom.b),
          blend(top.a, bottom.a)};
}

void Painter::sample_rows(PixelRows& rows, int y_begin, int y_end, Progress& progress) const {
  const int tiles_x = (rows.width() + kSampleTile - 1) / kSampleTile;
  const int tiles_y = (y_end - y_begin + kSampleTile - 1) / kSampleTile;
  const auto n_tiles = static_cast<std::size_t>(tiles_x) * static_cast<std::size_t>(tiles_y);
  parallel_for(n_tiles, options_.threads, 1, [&](std::size_t tile, int) {
    if (progress.is_cancelled()) return;
    const int x0 = static_cast<int>(tile) % tiles_x * kSampleTile;
    const int y0 = y_begin + static_cast<int>(tile) / tiles_x * kSampleTile;
    for (int y = y0; y < std::min(y0 + kSampleTile, y_end); ++y) {
      for (int x = x0; x < std::min(x0 + kSampleTile, rows.width()); ++x) {
        rows.at(x, y) = sample_pixel(x, y);
      }
    }
  });
}

Vec3f Painter::surface_light(const PixelRows& rows, int x, int y, int y_begin, int y_end) const {
  const PixelData& pixel = rows.at(x, y);
  if (pixel.coverage <= 0) return {};
  Visibility seen;
  if (pixel.sky_coverage > 0) {
    const Vec3f position = pixel.position * (1 / pixel.sky_coverage);
    seen = smooth_visibility(rows, x, y, y_begin, y_end, lens_.pixel_size_at(position));
  }
  // What hollows keep in, their walls partly give back: a geometric series of bounces.
  const float open = std::min(seen.sky, 1.0f);
  const float bounced = open / (1 - kReflectance * (1 - open));
  const auto strength = static_cast<float>(options_.ambient_occlusion);
  const float sky = 1 - strength * (1 - bounced);
  const float key = 1 - static_cast<float>(options_.shadow) * (1 - seen.key);
  return tone_map((pixel.flat + pixel.sky * sky + pixel.key * key) * (1 / pixel.coverage));
}

Color Painter::finish_pixel(const PixelRows& rows, int x, int y, int y_begin, int y_end) const {
  const PixelData& pixel = rows.at(x, y);
  const Color backdrop = background_at(options_, y);
  if (pixel.coverage <= 0) return backdrop;
  const float backdrop_share =
      (1 - pixel.coverage) * (static_cast<float>(backdrop.a) * (1.0f / 255));
  const float alpha = pixel.coverage + backdrop_share;
  const Vec3f sum = surface_light(rows, x, y, y_begin, y_end) * pixel.coverage +
                    to_linear(backdrop) * backdrop_share;
  return to_srgb(sum * (1 / alpha), alpha);
}

}  // namespace lode
