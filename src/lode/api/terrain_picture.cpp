#include "lode/api/terrain_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <numbers>

#include "lode/api/terrain_selection.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/core/vertical_unit.h"
#include "lode/mappers/contour_levels.h"
#include "lode/mappers/tin_contours.h"
#include "lode/render/ray_scene.h"

namespace lode {
namespace {

constexpr double kReliefShare = 0.125;
constexpr double kPixelShare = 0.25;
constexpr double kMostExaggeration = 1e6;
constexpr Color kContourColor{74, 52, 38};
constexpr double kContourWidth = 1.2;

/// From the world to metres from its middle.
struct PictureFrame {
  Vec<double, 2> middle;
  double x_scale = 1;
  double y_scale = 1;
  double z_scale = 1;  ///< With exaggeration.
  double z_middle = 0;
  Vec<double, 2> half;  ///< Metres.

  [[nodiscard]] Vec3d place(const Vec<double, 2>& at, double height) const {
    return {{(at[0] - middle[0]) * x_scale, (at[1] - middle[1]) * y_scale,
             (height - z_middle) * z_scale}};
  }
  [[nodiscard]] double longer_side() const { return 2 * std::max(half[0], half[1]); }
};

/// Of the ellipsoid at the middle, but not nearer to the poles than 85 degrees.
void take_metric(const HorizontalMetric& metric, PictureFrame& frame) {
  frame.x_scale = frame.y_scale = metric.metres();
  if (!metric.ellipsoid) return;
  constexpr double kStep = 1e-4;
  const double most = 85 * std::numbers::pi / 180 / metric.angle_unit;
  const double latitude = std::clamp(frame.middle[1], -most, most);
  frame.x_scale = metric.distance({{0, latitude}}, {{kStep, latitude}}) / kStep;
  frame.y_scale = metric.distance({{0, latitude}}, {{0, latitude + kStep}}) / kStep;
}

/// The largest of 1, 2, 5, 10, ... that is no more.
double nice_below(double most) {
  if (!(most > 1)) return 1;
  const double power = std::pow(10, std::floor(std::log10(most)));
  for (const double step : {5.0, 2.0})
    if (step * power <= most) return step * power;
  return power;
}

/// Round the raster, in its coordinates.
struct Extent {
  Vec<double, 2> lower;
  Vec<double, 2> upper;
};

Extent extent_of(const HeightFrame& grid) {
  const double columns = grid.n_columns - 1;
  const double rows = grid.n_rows - 1;
  const std::array corners{grid.world(0, 0), grid.world(columns, 0), grid.world(0, rows),
                           grid.world(columns, rows)};
  Extent extent{corners[0], corners[0]};
  for (const auto& corner : corners)
    for (std::size_t i = 0; i < 2; ++i) {
      extent.lower[i] = std::min(extent.lower[i], corner[i]);
      extent.upper[i] = std::max(extent.upper[i], corner[i]);
    }
  return extent;
}

PictureFrame frame_of(const HeightFrame& grid, const HorizontalMetric& metric,
                      const HeightRange& range, const TerrainPictureOptions& options,
                      TerrainPictureReport& report) {
  PictureFrame frame;
  const auto [lower, upper] = extent_of(grid);
  frame.middle = (lower + upper) * 0.5;
  take_metric(metric, frame);
  frame.half = {
      {(upper[0] - lower[0]) * frame.x_scale / 2, (upper[1] - lower[1]) * frame.y_scale / 2}};
  const double unit = metres_of_unit(grid.vertical_unit).value_or(1);
  report.is_vertical_unit_known = metres_of_unit(grid.vertical_unit).has_value();
  const double relief = (range.upper - range.lower) * unit;
  report.exaggeration = options.exaggeration.value_or(
      relief > 0 ? nice_below(kReliefShare * frame.longer_side() / relief) : 1);
  report.width = 2 * frame.half[0];
  report.depth = 2 * frame.half[1];
  frame.z_scale = unit * report.exaggeration;
  frame.z_middle = (range.lower + range.upper) / 2;
  return frame;
}

TerrainOptions tolerance_for(const TerrainPictureOptions& options, const PictureFrame& frame,
                             double finest) {
  TerrainOptions terrain = options.terrain;
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
  const auto& times = options.exaggeration;
  if (times && !(*times >= 1 / kMostExaggeration && *times <= kMostExaggeration))
    return fail("exaggeration: expected a number from {} to {}, got {}", 1 / kMostExaggeration,
                kMostExaggeration, *times);
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
  const Extent extent = extent_of(grid);
  LODE_CHECK(check_angles(metric, extent.lower, extent.upper));
  const PictureFrame frame = frame_of(grid, metric, range, options, report);
  const bool has_contours = options.contour_interval.has_value();
  const auto links = has_contours ? delaunay::TinLinks::kept : delaunay::TinLinks::left_out;
  LODE_TRY(const SelectedTerrain selected,
           terrain.origin().select(tolerance_for(options, frame, terrain.origin().finest_error()),
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
  const Box3d bounds = bounds_of(frame, range);
  if (!render.camera) render.camera = camera_of(bounds, options);
  report.camera = *render.camera;
  LODE_TRY(Image image, render_surface(surface, bounds, render, progress));
  report.seconds = watch.seconds();
  return image;
} catch (const std::bad_alloc&) {
  return out_of_memory("draw the terrain");
}

}  // namespace lode
