#include "lode/api/tetra_extraction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lode/api/finishing.h"
#include "lode/mappers/mesh_boundary.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/mappers/zero_normals.h"

namespace lode {
namespace {

bool is_focused(const Query& query) {
  return !(query.isovalues.empty() && query.field_ranges.empty() && query.opacity.empty() &&
           query.boxes.empty() && query.balls.empty() && query.half_spaces.empty() &&
           query.sections.empty());
}

/// Appends triangles with values and errors.
void append(const Surface& section, Surface& surface) {
  const auto first = static_cast<std::uint32_t>(surface.positions.size());
  const auto put = [](const auto& from, auto& to) {
    to.insert(to.end(), from.begin(), from.end());
  };
  put(section.positions, surface.positions);
  put(section.values, surface.values);
  put(section.errors, surface.errors);
  put(section.regions, surface.regions);
  if (surface.attributes.empty())
    for (const Attribute& from : section.attributes)
      surface.attributes.push_back({from.name, from.is_narrow, {}, from.error});
  for (std::size_t i = 0; i < section.attributes.size(); ++i)
    put(section.attributes[i].values, surface.attributes[i].values);
  for (const auto& [a, b, c] : section.triangles)
    surface.triangles.push_back({first + a, first + b, first + c});
}

/// Empty, with what all surfaces of meshes report.
TetraSurfaceReport begin(const TetraCutMesh& cut, Surface& surface) {
  surface.clear();
  surface.origin = cut.origin;
  surface.region_names = cut.mesh.region_names;
  return {.max_error = cut.report.max_error,
          .achieved_world_error = cut.report.achieved_world_error,
          .achieved_px = cut.report.achieved_px,
          .n_cut_cells = cut.report.n_cut_cells,
          .n_left_out = cut.report.n_left_out,
          .budget_met = cut.report.budget_met,
          .is_settled = cut.report.is_settled};
}

double largest_of(const std::vector<float>& errors) {
  return errors.empty() ? 0.0 : static_cast<double>(std::ranges::max(errors));
}

void count(const Surface& surface, TetraSurfaceReport& report) {
  report.n_triangles = surface.triangles.size();
  report.n_lines = surface.lines.size();
  report.n_vertices = surface.positions.size();
}

}  // namespace

Result<void> check_planes(std::span<const SectionPlane> planes) {
  if (planes.empty()) return fail("sections: expected planes, got none");
  for (const SectionPlane& plane : planes) {
    const double n = length(plane.normal);
    const double at = length(plane.point);
    if (!(n > 0) || !std::isfinite(n) || !std::isfinite(at))
      return fail("sections: expected finite points and normals other than zero, got another");
  }
  return {};
}

Query query_of(const TetraMeshOptions& options) {
  Query query = options.query;
  if (options.threshold && !is_focused(query)) query.field_ranges = {*options.threshold};
  return query;
}

Query query_of(const TetraSectionOptions& options) {
  Query query;
  query.isovalues = options.isovalues;
  query.field_ranges = options.field_ranges;
  for (const SectionPlane& plane : options.planes)
    query.sections.push_back({plane.point, plane.normal});
  query.max_error = options.max_error;
  query.max_world_error = options.max_world_error;
  query.budget = options.budget;
  return query;
}

void apply_threshold(const TetraMeshOptions& options, TetraCutMesh& cut) {
  if (options.threshold) {
    cut.report.n_left_out += keep_cells_within(cut.mesh, options.threshold->low,
                                               options.threshold->high, cut.vertex_ids);
  }
  cut.report.n_cells = cut.mesh.n_cells();
  cut.report.n_vertices = cut.mesh.positions.size();
  cut.report.largest_error = largest_of(cut.mesh.errors);
  // Cells that were left out are none of the answer.
  if (options.threshold)
    cut.report.achieved_error = std::min(cut.report.achieved_error, cut.report.largest_error);
}

TetraSurfaceReport make_isosurfaces(const TetraCutMesh& cut, const TetraSurfaceOptions& options,
                                    Surface& surface) {
  TetraSurfaceReport report = begin(cut, surface);
  const std::vector<double>& isovalues = options.query.isovalues;
  const MeshIsosurfaceOptions marching{.margin = cut.margin,
                                       .with_isovalues = isovalues.size() > 1,
                                       .gradients = cut.gradients,
                                       .threads = options.threads};
  for (const double isovalue : isovalues)
    report.achieved_error =
        std::max(report.achieved_error, add_isosurface(cut.mesh, isovalue, marching, surface));
  fill_zero_normals(surface, options.threads);
  count(surface, report);
  report.unmet = unmet_isovalues(surface, isovalues);
  return report;
}

TetraSurfaceReport make_sections(const TetraCutMesh& cut, const TetraSectionOptions& options,
                                 Surface& surface) {
  TetraSurfaceReport report = begin(cut, surface);
  for (const SectionPlane& plane : options.planes) {
    const SectionRounding rounding = section_rounding(cut.origin, cut.margin, plane.normal);
    const Surface section = cut_section(cut.mesh, plane, rounding);
    for (const double isovalue : options.isovalues)
      add_isolines(section, isovalue, rounding.margin, surface);
    if (options.isovalues.empty()) append(section, surface);
  }
  report.achieved_error = largest_of(surface.errors);
  count(surface, report);
  report.unmet = unmet_isovalues(surface, options.isovalues);
  return report;
}

TetraSurfaceReport make_boundary(const TetraCutMesh& cut, std::span<const std::uint32_t> patches,
                                 Threads threads, Surface& surface) {
  TetraSurfaceReport report = begin(cut, surface);
  surface = mesh_boundary(cut.mesh, cut.origin, threads, patches);
  surface.region_names = cut.mesh.region_names;
  report.achieved_error = largest_of(surface.errors);
  count(surface, report);
  return report;
}

}  // namespace lode
