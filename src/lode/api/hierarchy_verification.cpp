#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "lode/api/hierarchy_terrain.h"
#include "lode/mappers/tin_quality.h"

namespace lode {
namespace {

/// Of all levels at once.
Result<void> check_errors(const triangle_hierarchy::Hierarchy& hierarchy, const HeightGrid& grid,
                          Threads threads, Progress& progress, VerifyReport& report) {
  delaunay::Tin tin;
  tin.vertices = hierarchy.vertices;
  tin.heights = hierarchy.heights;
  for (const auto& triangle : hierarchy.triangles) tin.triangles.push_back(triangle.corner);
  // Of z' on a plane, in doubles.
  const HeightRange range = height_range(grid);
  const double slack = 0x1p-48 * std::max(std::abs(range.lower), std::abs(range.upper));
  std::atomic<std::uint64_t> n_beyond = 0;
  constexpr std::size_t kAtOnce = 256;
  parallel_for(tin.triangles.size(), threads, kAtOnce, [&](std::size_t t, int) {
    if (progress.is_cancelled()) return;
    const auto stated = static_cast<double>(hierarchy.triangles[t].error);
    if (worst_error_in(tin, t, hierarchy.scale(), grid) > stated + slack) ++n_beyond;
  });
  if (progress.is_cancelled()) return cancelled_error();
  report.add("triangles of all levels state their errors", tin.triangles.size(), n_beyond,
             n_beyond > 0 ? fmt::format("{} have samples that err by more", n_beyond.load()) : "");
  return {};
}

}  // namespace

Result<VerifyReport> HierarchyTerrain::verify(const HeightGrid& grid, Threads threads,
                                              Progress& progress) const {
  VerifyReport report;
  LODE_CHECK(check_source(source(), grid, report));
  for (int level = 0; level < hierarchy().n_levels(); ++level) {
    const delaunay::Tin tin = tin_of_level(hierarchy(), level, delaunay::TinLinks::left_out);
    LODE_TRY(const VerifyReport checked,
             verify_fine_tin(grid, tin, hierarchy().scale(), tolerance(level), threads, progress));
    for (const VerifyReport::Check& check : checked.checks)
      report.add(fmt::format("within {}: {}", tolerance(level), check.name), check.count,
                 check.passed ? 0 : 1, check.detail);
  }
  LODE_CHECK(check_errors(hierarchy(), grid, threads, progress, report));
  return report;
}

Result<VerifyReport> HierarchyTerrain::verify_alone(Threads /*threads*/,
                                                    Progress& /*progress*/) const {
  VerifyReport report;
  // What opening has found.
  report.add("meshes of levels conform and cover one domain once", hierarchy().triangles.size(), 0,
             "");
  report.add("reach bounds how far triangles lie out of those they refine",
             hierarchy().refinements.size(), n_out_of_reach(hierarchy()), "");
  return report;
}

}  // namespace lode
