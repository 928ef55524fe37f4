#include "lode/api/focused_surface.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <utility>

#include "lode/api/dataset_impl.h"
#include "lode/api/finishing.h"
#include "lode/api/live_query.h"
#include "lode/core/out_of_memory.h"
#include "lode/mappers/lattice_frame.h"
#include "lode/mappers/surface_order.h"

namespace lode {
namespace {

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Of a cut with its surface, and the surface that is written: 52 to 73 were measured.
constexpr std::uint64_t kBytesPerCell = 80;

/// What writing a surface of so many cells takes at most, so that a deadline is kept.
double finishing_seconds(std::size_t n_cells) { return 2e-4 + 3e-7 * static_cast<double>(n_cells); }

Result<Query> complete_focused(const diamond::FieldStats& stats, const FocusedOptions& options) {
  Query query = options.query;
  if (query.isovalues.size() != 1)
    return fail("a surface in focus: expected one isovalue, got {}", query.isovalues.size());
  if (!query.max_error && !query.max_error_px) {
    const bool is_limited = query.budget.is_limited() || options.deadline_s;
    query.max_error = is_limited ? 0 : default_tolerance(stats);
  }
  if (options.deadline_s && !(*options.deadline_s >= 0))
    return fail("deadline: expected a number >= 0, got {}", *options.deadline_s);
  LODE_CHECK(check_query(query));
  return query;
}

/// Cuts a surface of the extended field where the data ends; false if it does not reach beyond.
bool crop_to_data(const RegularGrid& grid, Surface& surface) {
  const double rounding = 4 * LatticeFrame::of(grid).rounding;
  Box3d data;
  for (std::size_t i = 0; i < 3; ++i) data.upper[i] = grid.dims[i] - 1;
  const auto is_outside = [&](const Vec3d& index) {
    for (std::size_t i = 0; i < 3; ++i)
      if (index[i] < -rounding || index[i] > data.upper[i] + rounding) return true;
    return false;
  };
  bool is_any = false;
  for (std::uint32_t v = 0; v < surface.positions.size() && !is_any; ++v)
    is_any = is_outside(grid.to_index(surface.world_position(v)));
  if (!is_any) return false;
  const bool is_aligned =
      std::all_of(grid.direction.rows.begin(), grid.direction.rows.end(), [](const Vec3d& row) {
        return std::all_of(row.v.begin(), row.v.end(),
                           [](double x) { return x == 0 || std::abs(x) == 1; });
      });
  if (is_aligned) {
    crop(surface, grid.world_bounds());
    return true;
  }
  // Its planes are no planes of the world: cut in the lattice.
  const auto to_float = [](const Vec3d& p) {
    return Vec3f{{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
  };
  const Vec3d origin = std::exchange(surface.origin, Vec3d{});
  for (Vec3f& p : surface.positions)
    p = to_float(grid.to_index(origin + Vec3d{{p[0], p[1], p[2]}}));
  crop(surface, data);
  for (Vec3f& p : surface.positions)
    p = to_float(grid.to_world(Vec3d{{p[0], p[1], p[2]}}) - origin);
  surface.origin = origin;
  return true;
}

/// Refines until the answer, the deadline or a cancellation.
template <typename Clock>
Result<void> refine(LiveQuery& live, const std::optional<double>& deadline, const Clock& clock,
                    Progress& progress) {
  constexpr int kStepsPerLook = 16;
  constexpr std::chrono::microseconds kLongestWait{500};
  for (int i = 0;; ++i) {
    const bool has_moved = i == 0 || live.step();
    if (has_moved && i % kStepsPerLook != 0) continue;
    if (progress.is_cancelled()) return cancelled_error();
    if (!has_moved)
      if (auto fault = live.fault()) return *fault;
    if (deadline && clock() + finishing_seconds(live.n_cells()) >= *deadline) return {};
    if (has_moved) continue;
    if (!live.standing().awaits_data) return {};
    live.wait(std::chrono::steady_clock::now() + kLongestWait);
  }
}

}  // namespace

Result<FocusedReport> extract_focused(const Dataset& dataset, const FocusedOptions& options,
                                      Surface& surface, Progress& progress) try {
  const std::function<double()> clock = options.clock ? options.clock : steady_seconds;
  const VolumeInfo& info = dataset.impl().info();
  const diamond::FieldStats& stats = dataset.impl().summary().stats;
  LODE_TRY(Query query, complete_focused(stats, options));
  FocusedReport report;
  report.max_error = query.max_error;
  report.max_error_px = query.max_error_px;
  surface.clear();
  if (std::ranges::count_if(info.grid.dims.v, [](std::int32_t n) { return n > 1; }) < 2) {
    report.standing.is_settled = true;  // it has no cells
    return report;
  }
  const double opening = clock();
  LODE_TRY(const auto* const pages, dataset.impl().pages(progress));
  if (pages == nullptr) LODE_CHECK(dataset.load(progress));
  const double opened = clock();
  const LiveQueryOptions live_options{.normals = options.normals,
                                      .with_views = query.max_error_px.has_value(),
                                      .memory_limit = options.memory_limit,
                                      .leaves_half = true};
  const Budget asked = query.budget;
  if (pages != nullptr && options.memory_limit > 0)
    query.budget = asked.within(options.memory_limit / 2, kBytesPerCell);
  LODE_TRY(const auto live, open_live_query(dataset, live_options, progress));
  const double start = clock();
  report.open_seconds = opened - opening;
  report.world_error_seconds = start - opened;
  live->set_query(query);
  std::optional<double> deadline;
  if (options.deadline_s) deadline = start + *options.deadline_s;
  LODE_CHECK(refine(*live, deadline, clock, progress));
  live->write(surface);
  report.standing = live->standing();
  const LatticeFrame frame = LatticeFrame::of(info.grid);
  report.coordinate_slack = (frame.margin + 4 * frame.rounding) * (stats.max - stats.min);
  if (query.budget != asked) {
    report.standing.budget_met = report.standing.n_cells <= asked.max_cells;
    if (report.standing.budget_ended) report.standing.memory_met = false;
  }
  // Pages of a file come in any order, and the surface with them.
  if (!deadline) put_in_order(surface);
  report.was_clipped = crop_to_data(info.grid, surface);
  if (stats.n_holes > 0) split_pinched_vertices(surface);
  const Dropped dropped = finish_edits(options, surface);
  report.components_dropped = dropped.components;
  report.triangles_dropped = dropped.cells;
  report.seconds = clock() - start;
  if (query.view && query.max_error_px) report.achieved_px = live->achieved_px();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the surface");
}

}  // namespace lode
