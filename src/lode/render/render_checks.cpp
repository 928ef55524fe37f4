#include "lode/render/render_checks.h"

#include <algorithm>

namespace lode {
namespace {

constexpr int kMaxSide = 16384;
constexpr double kMaxCoordinate = 1e150;  // Its square is still a double.

}  // namespace

Result<void> check_render_options(const RenderOptions& options) {
  if (options.width < 1 || options.width > kMaxSide || options.height < 1 ||
      options.height > kMaxSide) {
    return fail("picture size: expected 1 to {} pixels a side, got {} x {}", kMaxSide,
                options.width, options.height);
  }
  if (options.samples_per_pixel < 1 || options.samples_per_pixel > 4096) {
    return fail("samples per pixel: expected 1 to 4096, got {}", options.samples_per_pixel);
  }
  if (!(options.ambient_occlusion >= 0 && options.ambient_occlusion <= 1)) {
    return fail("ambient occlusion: expected 0 to 1, got {}", options.ambient_occlusion);
  }
  if (!(options.shadow >= 0 && options.shadow <= 1)) {
    return fail("shadow: expected 0 to 1, got {}", options.shadow);
  }
  if (!(options.line_width_px > 0 && options.line_width_px <= 1000)) {
    return fail("line width: expected above 0 and at most 1000 pixels, got {}",
                options.line_width_px);
  }
  if (options.camera) return check_camera(*options.camera);
  return {};
}

Result<void> check_render_bounds(const Box3d& bounds) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(bounds.lower[i] >= -kMaxCoordinate && bounds.upper[i] <= kMaxCoordinate &&
          bounds.lower[i] <= bounds.upper[i])) {
      return fail("bounds: expected lower <= upper and numbers up to {}, got {}..{} on axis {}",
                  kMaxCoordinate, bounds.lower[i], bounds.upper[i], i);
    }
  }
  return {};
}

Box3d union_of(const Box3d& a, const Box3d& b) {
  Box3d both = a;
  for (std::size_t i = 0; i < 3; ++i) {
    both.lower[i] = std::min(a.lower[i], b.lower[i]);
    both.upper[i] = std::max(a.upper[i], b.upper[i]);
  }
  return both;
}

}  // namespace lode
