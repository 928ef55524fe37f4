#include "lode/render/surface_colors.h"

#include <algorithm>
#include <cmath>

namespace lode {
namespace {

constexpr Color kDefaultSurface{201, 176, 148};
constexpr Color kDefaultLine{38, 70, 110};
// Beyond this many, isovalues are a continuous attribute rather than a choice of levels.
constexpr std::size_t kMaxLevels = 64;

// The distinct finite isovalues, ascending; cut short just past kMaxLevels.
std::vector<double> levels_of(const Surface& surface) {
  std::vector<double> levels;
  for (const double value : surface.isovalues) {
    if (!std::isfinite(value)) continue;
    const auto place = std::lower_bound(levels.begin(), levels.end(), value);
    if (place != levels.end() && *place == value) continue;
    levels.insert(place, value);
    if (levels.size() > kMaxLevels) break;
  }
  return levels;
}

std::vector<Vec3f> palette_of(const Surface& surface, std::size_t n_levels) {
  std::vector<Vec3f> palette;
  for (const Color& color : distinct_colors(n_levels)) palette.push_back(to_linear(color));
  if (surface.lines.empty()) return palette;
  for (std::size_t i = 0; i < n_levels; ++i) {
    // Lines are thin and the paper is white: stop short of the lightest colours.
    const double fraction = 0.9 * static_cast<double>(i) / static_cast<double>(n_levels - 1);
    palette[i] = to_linear(sequential_color(fraction));
  }
  return palette;
}

std::vector<Vec3f> paint_levels(const Surface& surface, const std::vector<double>& levels,
                                Threads threads) {
  const std::vector<Vec3f> palette = palette_of(surface, levels.size());
  std::vector<Vec3f> colors(surface.isovalues.size());
  parallel_for(colors.size(), threads, 1 << 16, [&](std::size_t i, int) {
    const auto place = std::lower_bound(levels.begin(), levels.end(), surface.isovalues[i]);
    const bool is_level = place != levels.end() && *place == surface.isovalues[i];
    colors[i] = palette[is_level ? static_cast<std::size_t>(place - levels.begin()) : 0];
  });
  return colors;
}

std::vector<Vec3f> paint_range(const Surface& surface, Threads threads) {
  double lower = 1e300;
  double upper = -1e300;
  for (const double value : surface.isovalues) {
    if (!std::isfinite(value)) continue;
    lower = std::min(lower, value);
    upper = std::max(upper, value);
  }
  std::vector<Vec3f> colors(surface.isovalues.size());
  parallel_for(colors.size(), threads, 1 << 16, [&](std::size_t i, int) {
    const double value = surface.isovalues[i];
    const double fraction = std::isfinite(value) ? (value - lower) / (upper - lower) : 0.0;
    colors[i] = to_linear(sequential_color(fraction));
  });
  return colors;
}

}  // namespace

Vec3f SurfaceColors::at(const std::array<std::uint32_t, 3>& triangle,
                        const std::array<float, 3>& weights) const {
  if (levels.empty() || levels[triangle[0]] < 0)
    return at(triangle[0]) * weights[0] + at(triangle[1]) * weights[1] +
           at(triangle[2]) * weights[2];
  float level = 0;
  for (std::size_t i = 0; i < 3; ++i) level += levels[triangle[i]] * weights[i];
  const float place = std::clamp(level, 0.0F, 1.0F) * static_cast<float>(ramp.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), ramp.size() - 2);
  const float share = place - static_cast<float>(below);
  return ramp[below] * (1 - share) + ramp[below + 1] * share;
}

SurfaceColors color_surface(const Surface& surface, const std::optional<Color>& color,
                            Threads threads) {
  const bool is_lines = surface.triangles.empty();
  SurfaceColors colors{.uniform = to_linear(is_lines ? kDefaultLine : kDefaultSurface),
                       .per_vertex = {}};
  if (color) colors.uniform = to_linear(*color);
  if (color || surface.isovalues.size() != surface.positions.size()) return colors;
  const std::vector<double> levels = levels_of(surface);
  if (levels.size() <= 1) return colors;
  colors.per_vertex = levels.size() <= kMaxLevels ? paint_levels(surface, levels, threads)
                                                  : paint_range(surface, threads);
  return colors;
}

}  // namespace lode
