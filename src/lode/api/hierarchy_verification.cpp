#include <fmt/format.h>

#include "lode/api/hierarchy_terrain.h"
#include "lode/api/lined_hierarchy.h"
#include "lode/api/point_hierarchy.h"
#include "lode/mappers/tin_quality.h"

namespace lode {
namespace {

/// Of all levels.
delaunay::Tin all_triangles(const triangle_hierarchy::Hierarchy& hierarchy) {
  delaunay::Tin tin;
  tin.vertices = hierarchy.vertices;
  tin.heights = hierarchy.heights;
  for (const auto& triangle : hierarchy.triangles) {
    tin.triangles.push_back(triangle.corner);
    tin.errors.push_back(triangle.error);
  }
  return tin;
}

}  // namespace

Result<VerifyReport> HierarchyTerrain::verify(const HeightGrid& grid, Threads threads,
                                              Progress& progress) const {
  VerifyReport report;
  LODE_CHECK(check_source(source(), grid, report));
  LODE_TRY(const LoadedLevels::Shared hierarchy, all_levels(progress));
  for (int level = 0; level < head_.n_levels(); ++level) {
    const delaunay::Tin tin = tin_of_level(*hierarchy, level, delaunay::TinLinks::left_out);
    LODE_TRY(const VerifyReport checked,
             verify_fine_tin(grid, tin, hierarchy->scale(), tolerance(level), threads, progress));
    for (const VerifyReport::Check& check : checked.checks)
      report.add(fmt::format("within {}: {}", tolerance(level), check.name), check.count,
                 check.passed ? 0 : 1, check.detail);
  }
  LODE_CHECK(check_stated_errors(all_triangles(*hierarchy), hierarchy->scale(), grid,
                                 "triangles of all levels state their errors", threads, progress,
                                 report));
  return report;
}

Result<VerifyReport> HierarchyTerrain::verify(const PointTerrain& terrain, Threads threads,
                                              Progress& progress) const {
  VerifyReport report;
  if (source().is_of_points) LODE_CHECK(check_source(source(), terrain, report));
  LODE_TRY(const LoadedLevels::Shared hierarchy, all_levels(progress));
  if (source().is_of_points)
    LODE_CHECK(check_against_points(*hierarchy, terrain, threads, progress, report));
  LODE_CHECK(compare_lines(*hierarchy, terrain, report));
  return report;
}

Result<VerifyReport> HierarchyTerrain::verify_alone(Threads /*threads*/, Progress& progress) const {
  VerifyReport report;
  LODE_TRY(const LoadedLevels::Shared hierarchy, all_levels(progress));
  // What reading has found.
  report.add("meshes of levels conform and cover one domain once", hierarchy->triangles.size(), 0,
             "");
  report.add("reach bounds how far triangles lie out of those they refine",
             hierarchy->refinements.size(), n_out_of_reach(*hierarchy), "");
  LODE_CHECK(check_lines(*hierarchy, progress, report));
  return report;
}

}  // namespace lode
