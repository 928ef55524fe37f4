#include "lode/api/mesh_picture.h"

#include <algorithm>
#include <array>
#include <new>
#include <numbers>

#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/creases.h"
#include "lode/mappers/mesh_boundary.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/render/legend.h"
#include "lode/render/ray_scene.h"
#include "lode/render/volume_renderer.h"

namespace lode {
namespace {

constexpr Color kLineColor{58, 64, 76};
constexpr double kCrease = std::numbers::pi / 6;

/// Positions of surfaces are relative to the middle of the mesh, where float32 is finest.
Vec3d middle_of(const Box3d& box) { return box.lower * 0.5 + box.upper * 0.5; }

/// Of a place that is coloured by value.
Vec3f value_color(const MeshPictureOptions& options, double value) {
  if (options.opacity && !options.color_attribute)
    return to_vec3f(options.opacity->at(value).color);
  const double width = options.colors.high - options.colors.low;
  return to_linear(sequential_color(width > 0 ? (value - options.colors.low) / width : 0.5));
}

/// What a part of the picture is coloured by.
const std::vector<double>& coloring_values(const Surface& part, const MeshPictureOptions& options) {
  return options.color_attribute ? part.attributes.at(*options.color_attribute).values
                                 : part.values;
}

/// Colours of a field from the least to the largest value.
std::vector<Vec3f> ramp_of(const MeshPictureOptions& options) {
  constexpr int kSteps = 4096;
  std::vector<Vec3f> ramp;
  ramp.reserve(kSteps + 1);
  const double width = options.colors.high - options.colors.low;
  for (int i = 0; i <= kSteps; ++i)
    ramp.push_back(value_color(options, options.colors.low + width * i / kSteps));
  return ramp;
}

/// Gives vertices from `first` on the colours of values.
void put_levels(const std::vector<double>& values, std::size_t first,
                const MeshPictureOptions& options, SurfaceColors& colors) {
  if (colors.ramp.empty()) colors.ramp = ramp_of(options);
  colors.levels.resize(first, -1);
  const double width = options.colors.high - options.colors.low;
  for (const double value : values)
    colors.levels.push_back(
        width > 0 ? static_cast<float>(std::clamp((value - options.colors.low) / width, 0.0, 1.0))
                  : 0.5F);
}

void add_isosurfaces(const SimplexMesh& mesh, const MeshPictureOptions& options,
                     OpaqueSurface& opaque, MeshPictureReport& report) {
  Surface& surface = opaque.surface;
  const MeshIsosurfaceOptions marching{.margin = rounding_margin(mesh.positions, surface.origin),
                                       .gradients = {},
                                       .threads = options.render.threads};
  for (const double isovalue : options.isovalues) {
    const std::size_t before = surface.triangles.size();
    add_isosurface(mesh, isovalue, marching, surface);
    if (surface.triangles.size() == before) report.unmet.push_back(isovalue);
  }
  report.n_triangles = surface.triangles.size();
  opaque.colors = color_surface(surface, options.render.color, options.render.threads);
  if (options.color_attribute && !surface.attributes.empty())
    put_levels(coloring_values(surface, options), 0, options, opaque.colors);
  surface.attributes.clear();
}

/// Adds triangles that have the colours of their values.
void add_colored(const Surface& part, const MeshPictureOptions& options, OpaqueSurface& opaque) {
  Surface& all = opaque.surface;
  const auto first = static_cast<std::uint32_t>(all.positions.size());
  put_levels(coloring_values(part, options), first, options, opaque.colors);
  all.positions.insert(all.positions.end(), part.positions.begin(), part.positions.end());
  for (const auto& [a, b, c] : part.triangles)
    all.triangles.push_back({first + a, first + b, first + c});
}

void add_section(const SimplexMesh& mesh, const SectionPlane& plane,
                 const MeshPictureOptions& options, OpaqueSurface& opaque) {
  const Vec3d& origin = opaque.surface.origin;
  const double margin = rounding_margin(mesh.positions, origin);
  add_colored(cut_section(mesh, plane, section_rounding(origin, margin, plane.normal)), options,
              opaque);
}

/// Shaded smoothly but for its creases.
void add_boundary(const SimplexMesh& mesh, const MeshPictureOptions& options,
                  OpaqueSurface& opaque) {
  Surface boundary = mesh_boundary(mesh, opaque.surface.origin, options.render.threads);
  for (const std::uint32_t v : split_at_creases(boundary.positions, kCrease, boundary.triangles)) {
    boundary.positions.push_back(Vec3f(boundary.positions[v]));
    boundary.values.push_back(double{boundary.values[v]});
    for (Attribute& attribute : boundary.attributes)
      attribute.values.push_back(double{attribute.values[v]});
  }
  add_colored(boundary, options, opaque);
}

/// By its two vertices, the smaller first, each edge once.
std::vector<std::array<std::uint32_t, 2>> edges_of(const SimplexMesh& mesh) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  edges.reserve(6 * mesh.tetrahedra.size());
  for (const auto& cell : mesh.tetrahedra)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j)
        edges.push_back({std::min(cell[i], cell[j]), std::max(cell[i], cell[j])});
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// Edges are lines, and vertices lines without length.
void add_lines(const SimplexMesh& mesh, const MeshPictureOptions& options, OpaqueSurface& opaque) {
  Surface& all = opaque.surface;
  const auto first = static_cast<std::uint32_t>(all.positions.size());
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  opaque.colors.per_vertex.resize(all.positions.size(), opaque.colors.uniform);
  for (const Vec3d& p : mesh.positions) all.positions.push_back(to_vec3f(p - all.origin));
  opaque.colors.per_vertex.resize(all.positions.size(), to_linear(kLineColor));
  const auto edges = edges_of(mesh);
  if (options.has_wireframe)
    for (const auto& [a, b] : edges) all.lines.push_back({first + a, first + b});
  if (!options.has_points) return;
  std::vector<bool> is_used(n);
  for (const auto& cell : mesh.tetrahedra)
    for (const std::uint32_t v : cell) is_used[v] = true;
  for (std::uint32_t v = 0; v < n; ++v)
    if (is_used[v]) all.lines.push_back({first + v, first + v});
}

/// Of colours by value, where there are some; of an empty mesh there are none.
Result<void> add_legend(const MeshPictureOptions& options, bool is_empty, Image& image) {
  const bool has_colors =
      options.has_boundary || !options.sections.empty() ||
      (options.color_attribute ? !options.isovalues.empty() : options.opacity.has_value());
  if (options.legend.empty() || !has_colors || is_empty) return {};
  return draw_legend({.title = options.legend,
                      .low = options.colors.low,
                      .high = options.colors.high,
                      .color = [&](double value) { return to_srgb(value_color(options, value)); }},
                     image);
}

}  // namespace

Result<TransferFunction> to_transfer_function(const std::string& preset_or_path,
                                              const Box3d& bounds, const Range& range) {
  if (!is_transfer_preset(preset_or_path)) return read_transfer_function(preset_or_path);
  const double diagonal = length(bounds.upper - bounds.lower);
  return transfer_preset(preset_or_path, {range.low, range.high, diagonal > 0 ? diagonal : 1});
}

Query query_of(const MeshPictureOptions& options) {
  Query query;
  // Colours of the boundary need all of it.
  if (options.has_boundary) return query;
  if (options.sections.empty()) {
    query.isovalues = options.isovalues;
    if (options.opacity)
      for (const TransferKnot& knot : options.opacity->knots)
        query.opacity.push_back({knot.value, knot.extinction});
  } else if (!options.opacity && options.isovalues.empty()) {
    for (const SectionPlane& plane : options.sections)
      query.sections.push_back({plane.point, plane.normal});
  }
  return query;
}

Result<Image> draw_mesh(const SimplexMesh& mesh, const MeshPictureOptions& options,
                        MeshPictureReport& report, Progress& progress) try {
  const Stopwatch watch;
  const SimplexMesh nothing;
  LODE_TRY(const MeshVolume volume,
           MeshVolume::build(options.opacity || options.boundary_opacity > 0 ? mesh : nothing,
                             options.render.threads));
  const Box3d bounds = bounds_of_cells(mesh);
  RenderOptions render = options.render;
  if (!render.camera)
    render.camera =
        default_camera(bounds, render.axes, static_cast<double>(render.width) / render.height);
  report = {.camera = *render.camera};
  OpaqueSurface opaque;
  opaque.surface.origin = middle_of(bounds);
  add_isosurfaces(mesh, options, opaque, report);
  for (const SectionPlane& plane : options.sections) add_section(mesh, plane, options, opaque);
  report.n_section_triangles = opaque.surface.triangles.size() - report.n_triangles;
  const std::size_t n_before = opaque.surface.triangles.size();
  if (options.has_boundary) add_boundary(mesh, options, opaque);
  report.n_boundary_triangles = opaque.surface.triangles.size() - n_before;
  if (options.has_wireframe || options.has_points) add_lines(mesh, options, opaque);
  report.n_lines = opaque.surface.lines.size();
  opaque.surface.isovalues.clear();
  const std::size_t n_vertices = opaque.surface.positions.size();
  if (!opaque.colors.levels.empty()) opaque.colors.levels.resize(n_vertices, -1);
  if (!opaque.colors.per_vertex.empty())
    opaque.colors.per_vertex.resize(n_vertices, opaque.colors.uniform);
  const TransferFunction clear{{TransferKnot{}}};
  const TransferFunction function = options.opacity.value_or(clear);
  auto image =
      render_volume({volume, function, opaque, options.boundary_opacity}, render, progress);
  if (image)
    if (const auto legend = add_legend(options, mesh.is_empty(), *image); !legend)
      report.legend_fault = legend.error().message;
  report.seconds = watch.seconds();
  return image;
} catch (const std::bad_alloc&) {
  return out_of_memory("draw the picture");
}

}  // namespace lode
