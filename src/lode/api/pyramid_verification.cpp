#include <fmt/format.h>

#include "lode/api/point_terrain.h"
#include "lode/api/pyramid_terrain.h"
#include "lode/api/vertex_checks.h"
#include "lode/mappers/point_errors.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid_check.h"

namespace lode {

using delaunay_pyramid::Pyramid;
using delaunay_pyramid::PyramidFaults;

namespace {

/// All that are kept, of whatever level.
delaunay::Tin all_triangles(const Pyramid& pyramid) {
  delaunay::Tin tin;
  tin.vertices = pyramid.vertices;
  tin.heights = pyramid.heights;
  for (const delaunay_pyramid::PyramidLevel& level : pyramid.levels) {
    tin.triangles.insert(tin.triangles.end(), level.triangles.begin(), level.triangles.end());
    tin.errors.insert(tin.errors.end(), level.errors.begin(), level.errors.end());
  }
  return tin;
}

void add_faults(const Pyramid& pyramid, const PyramidFaults& faults, VerifyReport& report) {
  const std::uint64_t n_levels = pyramid.head.n_levels();
  report.add("meshes of levels are Delaunay", n_levels, faults.n_other_levels,
             faults.n_other_levels > 0 ? fmt::format("{} are not", faults.n_other_levels) : "");
  report.add("levels have the angles that the file says", n_levels, faults.n_other_angles,
             faults.n_other_angles > 0 ? fmt::format("{} have not", faults.n_other_angles) : "");
  if (!pyramid.lines.empty())
    report.add("lines are edges of all levels, or chains of them", n_levels, faults.n_line_levels,
               faults.n_line_levels > 0 ? fmt::format("not of {}", faults.n_line_levels) : "");
  if (has_links(pyramid.head.encoding))
    report.add("links are to all triangles whose interiors meet", faults.n_owners,
               faults.n_wrong_owners,
               faults.n_wrong_owners > 0 ? fmt::format("not those of {}", faults.n_wrong_owners)
                                         : fmt::format("{} links", faults.n_links));
}

constexpr const char* kStated = "triangles of all levels state their errors";

}  // namespace

template <typename Verify>
Result<void> PyramidTerrain::verify_levels(const Pyramid& pyramid, const Verify& verify_tin,
                                           Threads threads, VerifyReport& report) const {
  const auto check = [&](std::size_t level, double tolerance) -> Result<void> {
    const delaunay::Tin tin = tin_of_level(pyramid, level, delaunay::TinLinks::left_out);
    LODE_TRY(const VerifyReport checked,
             verify_tin(tin, TerrainVerifyOptions{.max_error = tolerance, .threads = threads}));
    for (const VerifyReport::Check& one : checked.checks)
      report.add(fmt::format("within {}: {}", tolerance, one.name), one.count, one.passed ? 0 : 1,
                 one.detail);
    return {};
  };
  for (std::size_t level = 0; level < head_.n_levels(); ++level)
    LODE_CHECK(check(level, head_.tolerances[level]));
  // What it says to be the finest error is that of its last level.
  return check(head_.n_levels() - 1, head_.max_error);
}

Result<VerifyReport> PyramidTerrain::verify(const HeightGrid& grid, Threads threads,
                                            Progress& progress) const {
  VerifyReport report;
  LODE_CHECK(check_source(source(), grid, report));
  LODE_TRY(const Shared pyramid, all(progress));
  check_vertices(pyramid->vertices, pyramid->heights, grid, report);
  LODE_CHECK(verify_levels(
      *pyramid,
      [&](const delaunay::Tin& tin, const TerrainVerifyOptions& options) {
        return verify_sample_tin(grid, tin, options, progress);
      },
      threads, report));
  LODE_CHECK(
      check_stated_errors(all_triangles(*pyramid), 1, grid, kStated, threads, progress, report));
  return report;
}

Result<VerifyReport> PyramidTerrain::verify(const PointTerrain& terrain, Threads threads,
                                            Progress& progress) const {
  VerifyReport report;
  LODE_CHECK(check_source(source(), terrain, report));
  LODE_TRY(const Shared pyramid, all(progress));
  check_vertices(pyramid->vertices, pyramid->heights, terrain.points, report);
  check_lines(pyramid->vertices, pyramid->lines, terrain, report);
  LODE_CHECK(verify_levels(
      *pyramid,
      [&](const delaunay::Tin& tin, const TerrainVerifyOptions& options) {
        return verify_point_tin(terrain, tin, options, progress);
      },
      threads, report));
  const delaunay::Tin every = all_triangles(*pyramid);
  LODE_TRY(const std::uint64_t n_beyond,
           count_understated_points(every, terrain.points, threads, progress));
  report.add(kStated, every.triangles.size(), n_beyond,
             n_beyond > 0 ? fmt::format("{} have points that err by more", n_beyond) : "");
  return report;
}

Result<VerifyReport> PyramidTerrain::verify_alone(Threads /*threads*/, Progress& progress) const {
  LODE_TRY(const Shared pyramid, all(progress));
  VerifyReport report;
  // What reading has found.
  report.add("meshes of levels conform and cover one domain once", head_.n_levels(), 0, "");
  LODE_TRY(const PyramidFaults faults, find_faults(*pyramid, progress));
  add_faults(*pyramid, faults, report);
  return report;
}

}  // namespace lode
