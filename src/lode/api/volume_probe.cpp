// Probing of volumes: Dataset's.
#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include "lode/api/dataset_impl.h"
#include "lode/api/mesh_extraction.h"
#include "lode/api/opened_nodes.h"
#include "lode/api/probe.h"
#include "lode/api/probe_cells.h"
#include "lode/api/probe_focus.h"
#include "lode/api/volume_integral.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/models/diamond/cut_mesh.h"
#include "lode/models/diamond/query_cut.h"

namespace lode {
namespace {

/// What is looked for.
struct VolumeFocus {
  MeetsBox where;
  double max_error = 0;
  double snap = 0;  ///< As ProbeOptions'.
  std::uint64_t memory_limit = 0;
  Budget budget{};
};

/// Refines also what reaches across the end of the data: a corner there may have the value of a
/// hole, and nothing would be known of what is in the data.
struct RefinedBorder {
  Demand demand;

  [[nodiscard]] double operator()(const NodeFacts& node) const {
    if (node.is_at_border && demand.touches(node)) return std::numeric_limits<double>::infinity();
    return demand(node);
  }
  [[nodiscard]] bool touches(const NodeFacts& node) const { return demand.touches(node); }
};

Box3d box_round(std::span<const Vec3d> points, double slack) {
  Box3d box{points.front(), points.front()};
  for (const Vec3d& p : points)
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = std::min(box.lower[i], p[i]);
      box.upper[i] = std::max(box.upper[i], p[i]);
    }
  const Vec3d off{{slack, slack, slack}};
  return {box.lower - off, box.upper + off};
}

/// The cells of a cut that is fine where is looked, and those there only.
template <typename Nodes>
Result<ProbeCells> cells_of(Nodes& nodes, const VolumeFocus& focus, Progress& progress,
                            ProbeReport& report) {
  const auto& model = nodes.model();
  ProbeCells cells{.is_exact_at_vertices = false};  // where simplices are cut F' is a mean
  cells.domain = model.info.grid.world_bounds();
  cells.all = {model.stats.min, model.stats.max};
  cells.range_in = [all = cells.all](const Box3d&) { return all; };
  cells.rounding = distance_rounding(cells.domain);
  cells.snap = std::max(focus.snap, ProbeOptions::kSnapRounding * farthest_corner(cells.domain));
  const double slack = bounds_slack(cells.domain);
  const MeetsBox where = widened(focus.where, cells.snap);
  Demand demand = probe_demand(where, focus.max_error, slack);
  if (model.has_holes()) demand = RefinedBorder{std::move(demand)};
  LODE_CHECK(diamond::with_cut<3>(
      nodes, {demand, focus.budget, kMaxMeshCells, focus.memory_limit / 2}, progress,
      [&](const Cut& cut, const diamond::QueryCutReport& found) -> Result<void> {
        const auto is_near = [&](std::span<const Vec3d> corners) {
          return where(box_round(corners, slack));
        };
        LODE_TRY(const auto made,
                 diamond::mesh_of_cut<3>(nodes, cut, {.focus = demand, .is_near = is_near},
                                         cells.mesh, progress));
        report.achieved_error = made.achieved_error;
        report.n_cut_cells = found.n_cells;
        report.memory_met = found.memory_met;
        return {};
      }));
  report.max_error = focus.max_error;
  return cells;
}

Result<ProbeCells> cells_near(const Dataset::Impl& impl, const VolumeFocus& focus,
                              Progress& progress, ProbeReport& report) {
  return with_nodes(impl, focus.memory_limit, true, progress,
                    [&](auto& nodes) -> Result<ProbeCells> {
                      if constexpr (decltype(dimension_of(nodes))::value == 3)
                        return cells_of(nodes, focus, progress, report);
                      else
                        return fail("probing: expected a volume");
                    });
}

/// Refuses 2D data, and fields that there are none of.
template <typename Options>
Result<void> check_probed(const Dataset::Impl& impl, const Options& options) {
  if (impl.is_flat())
    return fail(
        "probing: expected a volume (diamond3d) or a mesh of cells, got 2D data ({} x {} x {} "
        "samples)",
        impl.info().grid.dims[0], impl.info().grid.dims[1], impl.info().grid.dims[2]);
  if (options.field != 0 || !options.along.empty())
    return fail("field: expected 0 alone, as a volume has one");
  return {};
}

/// Within the tolerance from cells of a cut, if these are so few that it is worth it: a cell of a
/// cut takes the time of hundreds of unit cells at full resolution, which are exact. Else none; nor
/// where there are holes, which take cells out of a limited cut of which only a part is removed.
Result<std::optional<IntegralReport>> integrate_coarsely(const Dataset::Impl& impl,
                                                         const IntegralOptions& options,
                                                         Progress& progress) {
  std::optional<IntegralReport> report;
  if (options.max_error == 0 || impl.summary().stats.n_holes > 0) return report;
  constexpr std::uint64_t kUnitCells = 200;
  ProbeReport probe;
  LODE_TRY(const ProbeCells cells,
           cells_near(impl,
                      {.where = options.box ? meets_box(*options.box) : meets_all(),
                       .max_error = options.max_error,
                       .memory_limit = options.memory_limit,
                       .budget = {.max_cells = n_unit_cells(impl, options.box) / kUnitCells}},
                      progress, probe));
  if (probe.achieved_error > options.max_error) return report;
  report = integrate_cells(cells, options);
  report->probe = probe;
  return report;
}

}  // namespace

Result<ProbeReport> Dataset::probe(std::span<const Vec3d> points, const ProbeOptions& options,
                                   std::vector<ProbedPoint>& found, Progress& progress) const try {
  const Stopwatch watch;
  LODE_CHECK(check_probed(*impl_, options));
  LODE_CHECK(check_probe(points, options.max_error));
  LODE_CHECK(check_snap(options.snap));
  ProbeReport report;
  LODE_TRY(const ProbeCells cells,
           cells_near(*impl_,
                      {meets_points(points), options.max_error, options.snap, options.memory_limit},
                      progress, report));
  found = probe_points_in(cells, points, options.threads);
  count_outside(found, report);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("probe the volume");
}

Result<ProbeReport> Dataset::probe_line(const ProbedLine& line, const ProbeOptions& options,
                                        std::vector<ProbedLinePoint>& found,
                                        Progress& progress) const try {
  LODE_CHECK(check_line(line));
  if (line.n_points > 0) {
    std::vector<ProbedPoint> points;
    LODE_TRY(const ProbeReport report, probe(points_on(line), options, points, progress));
    found = on_line(line, points);
    return report;
  }
  const Stopwatch watch;
  LODE_CHECK(check_probed(*impl_, options));
  LODE_CHECK(check_probe({}, options.max_error));
  ProbeReport report;
  LODE_TRY(const ProbeCells cells, cells_near(*impl_,
                                              {.where = meets_segment(line.begin, line.end),
                                               .max_error = options.max_error,
                                               .memory_limit = options.memory_limit},
                                              progress, report));
  found = probe_line_in(cells, line.begin, line.end, options.threads);
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("probe the volume");
}

Result<IntegralReport> Dataset::integrate(const IntegralOptions& options, Progress& progress) const
    try {
  const Stopwatch watch;
  LODE_CHECK(check_probed(*impl_, options));
  LODE_CHECK(check_integral(options));
  if (!options.regions.empty()) return fail("regions: expected none of a volume");
  LODE_TRY(std::optional<IntegralReport> report, integrate_coarsely(*impl_, options, progress));
  if (!report) {
    LODE_TRY(report, integrate_samples(*impl_, options, progress));
    report->probe.max_error = options.max_error;
  }
  report->probe.seconds = watch.seconds();
  return *report;
} catch (const std::bad_alloc&) {
  return out_of_memory("integrate the volume");
}

}  // namespace lode
