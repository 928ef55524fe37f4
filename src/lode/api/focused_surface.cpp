#include "lode/api/focused_surface.h"

#include <chrono>

#include "lode/api/dataset_impl.h"
#include "lode/api/live_query.h"
#include "lode/mappers/surface_edits.h"

namespace lode {
namespace {

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// What writing a surface of so many cells takes at most, so that a deadline is kept.
double finishing_seconds(std::size_t n_cells) { return 2e-4 + 1e-7 * static_cast<double>(n_cells); }

template <int D>
Result<Query> complete_focused(const diamond::Model<D>& model, const FocusedOptions& options) {
  Query query = options.query;
  if (query.isovalues.size() != 1)
    return fail("a surface in focus: expected one isovalue, got {}", query.isovalues.size());
  if (!query.max_error && !query.max_error_px) {
    const bool is_limited = query.budget.is_limited() || options.deadline_s;
    query.max_error = is_limited ? 0 : default_tolerance(model);
  }
  if (options.deadline_s && !(*options.deadline_s >= 0))
    return fail("deadline: expected a number >= 0, got {}", *options.deadline_s);
  LODE_CHECK(check_query(query));
  return query;
}

bool is_outside(const Surface& surface, const Box3d& bounds) {
  for (std::uint32_t v = 0; v < surface.positions.size(); ++v) {
    const Vec3d p = surface.world_position(v);
    for (std::size_t i = 0; i < 3; ++i)
      if (p[i] < bounds.lower[i] || p[i] > bounds.upper[i]) return true;
  }
  return false;
}

/// Refines until the answer, the deadline or a cancellation.
template <typename Clock>
void refine(LiveQuery& live, const std::optional<double>& deadline, const Clock& clock,
            Progress& progress) {
  constexpr int kStepsPerLook = 16;
  for (int i = 0;; ++i) {
    if (i % kStepsPerLook == 0) {
      if (progress.is_cancelled()) return;
      if (deadline && clock() + finishing_seconds(live.n_cells()) >= *deadline) return;
    }
    if (!live.step()) return;
  }
}

void finish(const FocusedOptions& options, bool has_holes, Surface& surface,
            FocusedReport& report) {
  if (has_holes) split_pinched_vertices(surface);
  fill_zero_normals(surface, options.threads);
  if (options.clip) {
    crop(surface, *options.clip);
    split_pinched_vertices(surface);
  }
  if (options.min_component > 1) {
    const Dropped dropped = drop_small_components(surface, options.min_component);
    report.components_dropped = dropped.components;
    report.triangles_dropped = dropped.cells;
  }
  if (options.orientation == Orientation::from_higher_values) flip_orientation(surface);
}

}  // namespace

Result<FocusedReport> extract_focused(const Dataset& dataset, const FocusedOptions& options,
                                      Surface& surface, Progress& progress) {
  const std::function<double()> clock = options.clock ? options.clock : steady_seconds;
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) -> Result<FocusedReport> {
        LODE_TRY(const Query query, complete_focused<D>(model, options));
        FocusedReport report;
        report.max_error = query.max_error;
        report.max_error_px = query.max_error_px;
        surface.clear();
        if (!model.shape.has_cells()) return report;
        const double opening = clock();
        LODE_TRY(const auto live, open_live_query(dataset, options.normals,
                                                  query.max_error_px.has_value(), progress));
        const double start = clock();
        report.world_error_seconds = start - opening;
        live->set_query(query);
        std::optional<double> deadline;
        if (options.deadline_s) deadline = start + *options.deadline_s;
        refine(*live, deadline, clock, progress);
        if (progress.is_cancelled()) return cancelled_error();
        live->write(surface);
        report.standing = live->standing();
        report.was_clipped = is_outside(surface, model.info.grid.world_bounds());
        if (report.was_clipped) crop(surface, model.info.grid.world_bounds());
        finish(options, model.has_holes(), surface, report);
        report.seconds = clock() - start;
        if (query.view && query.max_error_px) report.achieved_px = live->achieved_px();
        return report;
      },
      dataset.impl().model);
}

}  // namespace lode
