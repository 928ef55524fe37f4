#include "lode/api/terrain_picture.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "lode/api/picture_frame.h"
#include "lode/api/terrain_selection.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/contour_levels.h"
#include "lode/mappers/tin_contours.h"
#include "lode/render/ray_scene.h"

namespace lode {
namespace {

constexpr double kPixelShare = 0.25;
constexpr Color kContourColor{74, 52, 38};
constexpr double kContourWidth = 1.2;

TerrainOptions tolerance_for(const TerrainPictureOptions& options, const PictureFrame& frame,
                             const Camera& camera, const HorizontalMetric& metric, double finest) {
  TerrainOptions terrain = options.terrain;
  if (options.max_error_px) {
    TerrainFocus& focus = terrain.focus.emplace();
    focus.metric = metric;
    focus.view = TerrainView{.view = {camera, options.render.width, options.render.height},
                             .exaggeration = frame.exaggeration,
                             .max_error_px = options.max_error_px,
                             .has_tolerance = terrain.max_error.has_value()};
    return terrain;
  }
  if (terrain.max_error || terrain.max_cells) return terrain;
  const int pixels = std::max(options.render.width, options.render.height);
  terrain.max_error = std::max(finest, kPixelShare * frame.longer_side() / pixels / frame.z_scale);
  return terrain;
}

/// Land from 0, or what is lowest above, to the highest; what is below 0 from the lowest to 0.
std::vector<Vec3f> colors_of(std::span<const double> heights, const HeightRange& range) {
  const double shore = std::clamp(0.0, range.lower, range.upper);
  std::vector<Vec3f> colors;
  colors.reserve(heights.size());
  for (const double height : heights) {
    const bool is_water = height < 0;
    const double low = is_water ? range.lower : shore;
    const double high = is_water ? shore : range.upper;
    const double share = high > low ? (height - low) / (high - low) : 0;
    colors.push_back(to_linear(is_water ? depth_color(share) : elevation_color(share)));
  }
  return colors;
}

Surface picture_surface(const delaunay::Tin& tin, const HeightFrame& grid,
                        const PictureFrame& frame) {
  Surface surface;
  surface.positions.reserve(tin.vertices.size());
  for (std::size_t i = 0; i < tin.vertices.size(); ++i) {
    const delaunay::LatticePoint& v = tin.vertices[i];
    surface.positions.push_back(to_vec3f(frame.place(grid.world(v.x, v.y), tin.heights[i])));
  }
  surface.values = tin.heights;
  surface.triangles = tin.triangles;
  if (grid.is_mirrored())
    for (auto& triangle : surface.triangles) std::swap(triangle[1], triangle[2]);
  return surface;
}

/// On the surface.
Result<void> add_contours(const delaunay::Tin& tin, const HeightFrame& grid,
                          std::span<const double> levels, const PictureFrame& frame,
                          Surface& surface, TerrainPictureReport& report, Progress& progress) {
  LODE_TRY(const ContourSet traced, trace_contours(tin, levels, KeptLines::drawable, progress));
  for (const ContourLine& line : traced.lines) {
    const auto first = static_cast<std::uint32_t>(surface.positions.size());
    for (const delaunay::Point& at : line.points)
      surface.positions.push_back(
          to_vec3f(frame.place(grid.world(at[0], at[1]), levels[line.level])));
    for (std::uint32_t i = first + 1; i < surface.positions.size(); ++i)
      surface.lines.push_back({i - 1, i});
  }
  report.n_contours = traced.lines.size();
  return {};
}

/// All of the raster, whatever of it has heights.
Box3d bounds_of(const PictureFrame& frame, const HeightRange& range) {
  const double half = (range.upper - range.lower) / 2 * frame.z_scale;
  return {{{-frame.half[0], -frame.half[1], -half}}, {{frame.half[0], frame.half[1], half}}};
}

Camera camera_of(const Box3d& bounds, const TerrainPictureOptions& options) {
  const double aspect = static_cast<double>(options.render.width) / options.render.height;
  if (!options.is_from_above) return default_camera(bounds, viewing_axes(Frame::unknown), aspect);
  Box3d flat = bounds;
  flat.lower[2] = flat.upper[2] = 0;
  return top_camera(flat, aspect);
}

Result<void> check_picture(const TerrainPictureOptions& options) {
  const auto& interval = options.contour_interval;
  if (interval && !(*interval > 0 && std::isfinite(*interval)))
    return fail("contours: expected an interval > 0, got {}", *interval);
  return {};
}

}  // namespace

Result<Image> draw_terrain(const Terrain& terrain, const HorizontalMetric& metric,
                           const TerrainPictureOptions& options, TerrainPictureReport& report,
                           Progress& progress) try {
  const Stopwatch watch;
  LODE_CHECK(check_picture(options));
  const HeightFrame& grid = terrain.frame();
  const HeightRange range = terrain.range();
  LODE_TRY(const PictureFrame frame, picture_frame(grid, range, metric, options.exaggeration));
  report.exaggeration = frame.exaggeration;
  report.is_vertical_unit_known = frame.is_vertical_unit_known;
  report.width = 2 * frame.half[0];
  report.depth = 2 * frame.half[1];
  const bool has_contours = options.contour_interval.has_value();
  const auto links = has_contours ? delaunay::TinLinks::kept : delaunay::TinLinks::left_out;
  const Box3d bounds = bounds_of(frame, range);
  report.camera = options.render.camera.value_or(camera_of(bounds, options));
  LODE_TRY(const SelectedTerrain selected,
           terrain.origin().select(tolerance_for(options, frame, report.camera, metric,
                                                 terrain.origin().finest_error()),
                                   links, progress));
  report.terrain = selected.report;
  Surface surface = picture_surface(selected.tin, grid, frame);
  RenderOptions render = options.render;
  std::vector<Vec3f> colors = colors_of(surface.values, range);
  if (render.color) std::ranges::fill(colors, to_linear(*render.color));
  if (has_contours) {
    auto levels =
        levels_between(0, *options.contour_interval, range.lower, range.upper, LowestLevel::from);
    if (!levels) return fail("contours: {}", levels.error().message);
    LODE_CHECK(add_contours(selected.tin, grid, *levels, frame, surface, report, progress));
    colors.resize(surface.positions.size(), to_linear(kContourColor));
    render.line_width_px = kContourWidth;
  }
  surface.values.clear();  // Of the TIN's vertices alone.
  render.vertex_colors = colors;
  render.camera = report.camera;
  LODE_TRY(Image image, render_surface(surface, bounds, render, progress));
  report.seconds = watch.seconds();
  return image;
} catch (const std::bad_alloc&) {
  return out_of_memory("draw the terrain");
}

}  // namespace lode
