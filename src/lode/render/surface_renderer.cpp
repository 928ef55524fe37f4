#include "lode/render/surface_renderer.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "lode/core/out_of_memory.h"
#include "lode/render/lens.h"
#include "lode/render/painter.h"
#include "lode/render/pixel_filter.h"
#include "lode/render/ray_scene.h"
#include "lode/render/render_checks.h"
#include "lode/render/surface_colors.h"

namespace lode {
namespace {

bool is_finite(const Vec3d& a) {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

// Bands of rows, each sampled a filter radius ahead of where it is finished.
Result<Image> paint(const Painter& painter, const RenderOptions& options, Progress& progress) {
  const int height = options.height;
  Image image{.width = options.width, .height = height, .pixels = {}};
  image.pixels.resize(static_cast<std::size_t>(options.width) * static_cast<std::size_t>(height));
  PixelRows rows(options.width, std::min(height, kPictureBandRows + 2 * kFilterRadius));
  int sampled = 0;
  for (int y0 = 0; y0 < height; y0 += kPictureBandRows) {
    const int y1 = std::min(y0 + kPictureBandRows, height);
    const int ahead = std::min(y1 + kFilterRadius, height);
    painter.sample_rows(rows, sampled, ahead, progress);
    sampled = ahead;
    if (progress.is_cancelled()) return cancelled_error();
    parallel_for(static_cast<std::size_t>(y1 - y0), options.threads, 4, [&](std::size_t i, int) {
      const int y = y0 + static_cast<int>(i);
      Color* const out = image.pixels.data() +
                         static_cast<std::size_t>(y) * static_cast<std::size_t>(options.width);
      const int y_begin = std::max(0, y0 - kFilterRadius);
      for (int x = 0; x < options.width; ++x) {
        out[x] = painter.finish_pixel(rows, x, y, y_begin, ahead);
      }
    });
    progress.report("rendering", static_cast<double>(y1) / height);
  }
  return image;
}

}  // namespace

Box3d bounds_of(const Surface& surface, const Box3d& otherwise) {
  if (surface.is_empty()) return otherwise;
  Box3d box{{{1e300, 1e300, 1e300}}, {{-1e300, -1e300, -1e300}}};
  const auto include = [&](std::uint32_t vertex) {
    if (vertex >= surface.positions.size()) return;
    const Vec3d p = surface.world_position(vertex);
    if (is_finite(p)) box = union_of(box, {p, p});
  };
  for (const auto& triangle : surface.triangles) {
    for (const std::uint32_t vertex : triangle) include(vertex);
  }
  for (const auto& line : surface.lines) {
    for (const std::uint32_t vertex : line) include(vertex);
  }
  return box.lower[0] <= box.upper[0] ? box : otherwise;
}

Camera framing_camera(const Surface& surface, const Box3d& bounds, const RenderOptions& options) {
  const double aspect = static_cast<double>(options.width) / options.height;
  const Vec3d size = bounds.upper - bounds.lower;
  const bool is_flat = std::min({size[0], size[1], size[2]}) <= 1e-3 * length(size);
  if (is_flat && surface.triangles.empty()) return top_camera(bounds, aspect);
  return default_camera(bounds_of(surface, bounds), options.axes, aspect);
}

Result<Image> render_surface(const Surface& surface, const Box3d& bounds,
                             const RenderOptions& options, Progress& progress) try {
  LODE_CHECK(check_render_options(options));
  LODE_CHECK(check_render_bounds(bounds));
  const Camera camera = options.camera ? *options.camera : framing_camera(surface, bounds, options);
  const Normalization normalization =
      normalization_of(union_of(bounds, bounds_of(surface, bounds)));
  const Lens lens(camera, normalization, options.width, options.height);
  const double line_radius = std::min(lens.pixel_size() * options.line_width_px / 2, 0.1);
  SurfaceColors colors = color_surface(surface, options.color, options.threads);
  if (!options.vertex_colors.empty()) {
    if (options.vertex_colors.size() != surface.positions.size())
      return fail("surface: expected {} colours, one per vertex, got {}", surface.positions.size(),
                  options.vertex_colors.size());
    colors.per_vertex.assign(options.vertex_colors.begin(), options.vertex_colors.end());
  }
  const SceneOptions scene_options{
      .normalization = normalization, .line_radius = line_radius, .threads = options.threads};
  LODE_TRY(const RayScene scene, RayScene::build(surface, colors, scene_options, progress));
  const Painter painter(scene, lens, 1.001 + line_radius, options);
  return paint(painter, options, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("draw the picture");
}

}  // namespace lode
