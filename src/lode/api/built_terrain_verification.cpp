#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/built_terrain.h"
#include "lode/api/built_terrain_impl.h"
#include "lode/core/out_of_memory.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/mappers/tin_quality.h"
#include "lode/mappers/tin_surface.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode {
namespace {

using insertions::History;

/// That the file is of a raster of this size.
Result<void> check_size(const History& history, const HeightGrid& grid) {
  if (history.frame.n_columns != grid.n_columns || history.frame.n_rows != grid.n_rows)
    return fail("expected the raster that it was built of, {} x {} samples, got one of {} x {}",
                history.frame.n_columns, history.frame.n_rows, grid.n_columns, grid.n_rows);
  return {};
}

/// What the file says of the raster, and the height of each of its vertices.
Result<void> check_source(const History& history, const HeightGrid& grid, VerifyReport& report) {
  LODE_TRY(const delaunay::GridDomain domain, delaunay::find_domain(grid));
  const HeightRange range = height_range(grid);
  const std::array holds{history.frame.to_world == grid.to_world,
                         history.frame.crs == grid.crs,
                         history.frame.vertical_unit == grid.vertical_unit,
                         history.range.lower == range.lower && history.range.upper == range.upper,
                         history.n_samples == domain.n_samples,
                         history.n_missing == grid.n_missing(),
                         history.n_left_out == domain.n_left_out};
  constexpr std::array kNames{"place", "CRS", "unit", "range", "samples", "missing", "left out"};
  std::string wrong;
  for (std::size_t i = 0; i < holds.size(); ++i)
    if (!holds[i]) wrong += fmt::format("{}{}", wrong.empty() ? "" : ", ", kNames[i]);
  report.add("the file says of the raster what it is", holds.size(), wrong.empty() ? 0 : 1,
             wrong.empty() ? "" : "not so: " + wrong);
  std::uint64_t n_other = 0;
  for (std::size_t v = 0; v < history.vertices.size(); ++v) {
    const delaunay::LatticePoint p = history.vertices[v];
    if (!grid.has_height(p.x, p.y) || grid.height(p.x, p.y) != history.heights[v]) ++n_other;
  }
  report.add("vertices have the samples' heights", history.vertices.size(), n_other,
             n_other > 0 ? fmt::format("{} have others", n_other) : "");
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
  const HeightRange range = height_range(grid);
  const double slack = 0x1p-48 * std::max(std::abs(range.lower), std::abs(range.upper));
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

/// Tolerances, and when they are kept.
std::vector<std::pair<double, std::uint32_t>> levels_to_check(const History& history,
                                                              const std::vector<double>& levels) {
  std::vector<std::pair<double, std::uint32_t>> checked;
  checked.reserve(levels.size() + history.level_ends.size() + 1);
  for (const double tolerance : levels)
    checked.emplace_back(tolerance, time_within(history, tolerance));
  for (const std::uint32_t end : history.level_ends) {
    const delaunay::Tin tin = tin_at(history, end, delaunay::TinLinks::kept);
    checked.emplace_back(static_cast<double>(*std::ranges::max_element(tin.errors)), end);
  }
  // All that there is keeps the finest error.
  checked.emplace_back(history.max_error, history.n_nodes());
  return checked;
}

}  // namespace

Result<VerifyReport> BuiltTerrain::verify(const HeightGrid& grid, Threads threads,
                                          Progress& progress) const try {
  const History& history = impl_->levelled.history;
  LODE_CHECK(check_size(history, grid));
  VerifyReport report;
  LODE_CHECK(check_source(history, grid, report));
  for (const auto& [tolerance, time] : levels_to_check(history, impl_->levelled.levels)) {
    const delaunay::Tin tin = tin_at(history, time, delaunay::TinLinks::left_out);
    const Surface surface = to_surface(tin, history.frame).surface;
    LODE_TRY(
        const VerifyReport level,
        verify_terrain(grid, surface,
                       {.max_error = tolerance, .shape = shape_of(model()), .threads = threads},
                       progress));
    for (const VerifyReport::Check& check : level.checks)
      report.add(fmt::format("within {}: {}", tolerance, check.name), check.count,
                 check.passed ? 0 : 1, check.detail);
  }
  LODE_CHECK(check_errors(history, grid, threads, progress, report));
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("verify the model");
}

}  // namespace lode
