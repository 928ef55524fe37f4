#include "lode/api/mesh_picture.h"

#include <algorithm>
#include <new>

#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/render/ray_scene.h"
#include "lode/render/volume_renderer.h"

namespace lode {
namespace {

/// Positions of surfaces are relative to the middle of the mesh, where float32 is finest.
Vec3d middle_of(const Box3d& box) { return box.lower * 0.5 + box.upper * 0.5; }

Vec3f section_color(const MeshPictureOptions& options, double value) {
  if (options.opacity) return to_vec3f(options.opacity->at(value).color);
  const double width = options.colors.high - options.colors.low;
  return to_linear(sequential_color(width > 0 ? (value - options.colors.low) / width : 0.5));
}

void add_isosurfaces(const SimplexMesh& mesh, const MeshPictureOptions& options,
                     OpaqueSurface& opaque, MeshPictureReport& report) {
  Surface& surface = opaque.surface;
  const double margin = rounding_margin(mesh, surface.origin);
  for (const double isovalue : options.isovalues) {
    const std::size_t before = surface.triangles.size();
    add_isosurface(mesh, isovalue, margin, surface);
    if (surface.triangles.size() == before) report.unmet.push_back(isovalue);
  }
  report.n_triangles = surface.triangles.size();
  opaque.colors = color_surface(surface, options.render.color, options.render.threads);
}

/// Vertices of its own, each with its value's colour.
void add_section(const SimplexMesh& mesh, const SectionPlane& plane,
                 const MeshPictureOptions& options, OpaqueSurface& opaque) {
  Surface& all = opaque.surface;
  const double snap = rounding_margin(mesh, all.origin);
  const LatticeFrame frame{
      .surface_origin = all.origin,
      .origin = {},
      .to_world = {{Vec3d{{snap, 0, 0}}, Vec3d{{0, snap, 0}}, Vec3d{{0, 0, snap}}}},
      .margin = 1};
  const Surface section = cut_section(mesh, plane, frame);
  opaque.colors.per_vertex.resize(all.positions.size(), opaque.colors.uniform);
  const auto first = static_cast<std::uint32_t>(all.positions.size());
  all.positions.insert(all.positions.end(), section.positions.begin(), section.positions.end());
  for (const double value : section.values)
    opaque.colors.per_vertex.push_back(section_color(options, value));
  for (const auto& [a, b, c] : section.triangles)
    all.triangles.push_back({first + a, first + b, first + c});
}

}  // namespace

Result<TransferFunction> to_transfer_function(const std::string& preset_or_path,
                                              const SimplexMesh& mesh, const Range& range) {
  if (!is_transfer_preset(preset_or_path)) return read_transfer_function(preset_or_path);
  const Box3d box = bounds_of_cells(mesh);
  const double diagonal = length(box.upper - box.lower);
  return transfer_preset(preset_or_path, {range.low, range.high, diagonal > 0 ? diagonal : 1});
}

Result<Image> draw_mesh(const SimplexMesh& mesh, const MeshPictureOptions& options,
                        MeshPictureReport& report, Progress& progress) try {
  const Stopwatch watch;
  const SimplexMesh nothing;
  LODE_TRY(const MeshVolume volume,
           MeshVolume::build(options.opacity ? mesh : nothing, options.render.threads));
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
  opaque.surface.isovalues.clear();
  const TransferFunction clear{{TransferKnot{}}};
  auto image = render_volume(volume, options.opacity.value_or(clear), opaque, render, progress);
  report.seconds = watch.seconds();
  return image;
} catch (const std::bad_alloc&) {
  return out_of_memory("draw the picture");
}

}  // namespace lode
