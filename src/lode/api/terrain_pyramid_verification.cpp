#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <new>

#include "lode/api/terrain_pyramid.h"
#include "lode/api/terrain_pyramid_impl.h"
#include "lode/core/out_of_memory.h"
#include "lode/mappers/tin_quality.h"
#include "lode/mappers/tin_surface.h"
#include "lode/models/terrain/delaunay_pyramid/extract.h"

namespace lode {
namespace {

using delaunay_pyramid::History;

/// That the file is of this raster, as far as numbers tell.
Result<void> check_raster(const History& history, const HeightGrid& grid) {
  if (history.frame.n_columns != grid.n_columns || history.frame.n_rows != grid.n_rows)
    return fail("expected the raster that it was built of, {} x {} samples, got one of {} x {}",
                history.frame.n_columns, history.frame.n_rows, grid.n_columns, grid.n_rows);
  return {};
}

/// All triangles that there ever were.
delaunay::Tin all_triangles(const History& history) {
  delaunay::Tin tin;
  tin.vertices = history.vertices;
  tin.heights = history.heights;
  for (const auto& triangle : history.triangles) tin.triangles.push_back(triangle.corner);
  return tin;
}

Result<void> check_errors(const History& history, const HeightGrid& grid, Threads threads,
                          Progress& progress, VerifyReport& report) {
  const delaunay::Tin tin = all_triangles(history);
  // Of z' on a plane, in doubles.
  const double slack =
      0x1p-48 * std::max(std::abs(history.range.lower), std::abs(history.range.upper));
  std::atomic<std::uint64_t> n_beyond = 0;
  constexpr std::size_t kAtOnce = 256;
  parallel_for(tin.triangles.size(), threads, kAtOnce, [&](std::size_t t, int) {
    if (progress.is_cancelled()) return;
    const double stated = history.triangles[t].error;
    if (worst_error_in(tin, t, 1, grid) > stated + slack) ++n_beyond;
  });
  if (progress.is_cancelled()) return cancelled_error();
  report.add("triangles of all times state their errors", tin.triangles.size(), n_beyond,
             n_beyond > 0 ? fmt::format("{} have samples that err by more", n_beyond.load()) : "");
  return {};
}

}  // namespace

Result<VerifyReport> TerrainPyramid::verify(const HeightGrid& grid, Threads threads,
                                            Progress& progress) const try {
  const History& history = impl_->pyramid.history;
  LODE_CHECK(check_raster(history, grid));
  VerifyReport report;
  for (const double tolerance : impl_->pyramid.levels) {
    const delaunay::Tin tin =
        tin_at(history, time_within(history, tolerance), delaunay::TinLinks::left_out);
    const Surface surface = to_surface(tin, history.frame).surface;
    LODE_TRY(const VerifyReport level, verify_terrain(grid, surface, tolerance, threads, progress));
    for (const VerifyReport::Check& check : level.checks)
      report.add(fmt::format("within {}: {}", tolerance, check.name), check.count,
                 check.passed ? 0 : 1, check.detail);
  }
  LODE_CHECK(check_errors(history, grid, threads, progress, report));
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("verify the pyramid");
}

}  // namespace lode
