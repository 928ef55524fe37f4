#include "lode/api/tetra_probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "lode/api/probe_cells.h"
#include "lode/api/probe_focus.h"
#include "lode/api/tetra_info.h"
#include "lode/locate/cell_locator.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"

namespace lode {
namespace {

using tetra_mt::kNone;
using tetra_mt::PackedHierarchy;
using tetra_mt::TetraCut;
using tetra_mt::midpoint::Forest;
using tetra_mt::midpoint::MidpointCut;

/// Cuts of half edges, and of midpoints, by what both have.
class HalfEdgeView {
 public:
  using Cut = TetraCut;

  HalfEdgeView(const PackedHierarchy& hierarchy, std::size_t field)
      : hierarchy_(hierarchy), field_(field), cut_(hierarchy, field) {}

  [[nodiscard]] Cut& cut() { return cut_; }
  [[nodiscard]] const Cut& cut() const { return cut_; }
  [[nodiscard]] Vec3d position(std::uint32_t vertex) const { return hierarchy_.position(vertex); }
  [[nodiscard]] double value(std::uint32_t vertex) const {
    return hierarchy_.value(vertex, field_);
  }
  [[nodiscard]] std::uint32_t maker(std::uint32_t slot) const { return cut_.maker(slot); }
  [[nodiscard]] std::uint32_t region(std::uint32_t slot) const { return cut_.region(slot); }

 private:
  const PackedHierarchy& hierarchy_;
  std::size_t field_;
  Cut cut_;
};

class MidpointView {
 public:
  using Cut = MidpointCut;

  MidpointView(const Forest& forest, std::size_t /*field*/) : cut_(forest) {}

  [[nodiscard]] Cut& cut() { return cut_; }
  [[nodiscard]] const Cut& cut() const { return cut_; }
  [[nodiscard]] Vec3d position(std::uint32_t vertex) const { return cut_.position(vertex); }
  [[nodiscard]] double value(std::uint32_t vertex) const { return cut_.value(vertex); }
  [[nodiscard]] std::uint32_t maker(std::uint32_t slot) const {
    return cut_.maker(cut_.slots()[slot]);
  }
  [[nodiscard]] std::uint32_t region(std::uint32_t slot) const { return cut_.slots()[slot].region; }

 private:
  Cut cut_;
};

/// What candidates say of F. A cell of the reference that a cut has not got is brought by one node
/// that is not applied. All its corners are in the range, and itself in the bounds, that this node
/// states, and so in those of the one candidate that comes before it along discovery, as both are
/// nested. So at any point F is in one of the ranges of candidates whose bounds hold the point, or
/// the cut's cell there is the reference's.
class CandidateRanges {
 public:
  template <typename Model>
  CandidateRanges(const Engine<Model>& engine, const Model& cut, const Range& all,
                  const Box3d& domain)
      : all_(all) {
    const Cut& nodes = engine.cut();
    const double slack = bounds_slack(domain);
    for (std::size_t at = 0; at < nodes.n_places(); ++at) {
      const Cut::Entry& entry = nodes[static_cast<Cut::Place>(at)];
      if (entry.state != Cut::State::candidate) continue;
      const Box3d box = box_of(cut.bounds(entry.id), slack);
      const auto first = static_cast<std::uint32_t>(corners_.size());
      corners_.insert(corners_.end(), {box.lower, box.upper});
      boxes_.push_back({first, first + 1, first, first + 1});
      ranges_.push_back(without_bounds(entry.facts(), cut.range_reference()).range);
      error_ = std::max(error_, static_cast<double>(entry.error));
    }
    locator_ = std::make_unique<const CellLocator>(corners_, boxes_, Threads{1});
  }

  /// Empty where no candidate's bounds are.
  [[nodiscard]] Range range_of_candidates(const Box3d& where) const {
    Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    const auto meets = [&](const Box3d& box) {
      bool is = true;
      for (std::size_t i = 0; i < 3; ++i)
        is = is && box.lower[i] <= where.upper[i] && where.lower[i] <= box.upper[i];
      return is;
    };
    locator_->visit_where(meets, [&](std::uint32_t at) {
      range.low = std::min(range.low, ranges_[at].low);
      range.high = std::max(range.high, ranges_[at].high);
    });
    if (range.is_empty()) return range;
    return {std::max(range.low, all_.low), std::min(range.high, all_.high)};
  }
  [[nodiscard]] Range range_in(const Box3d& where) const {
    const Range range = range_of_candidates(where);
    return range.is_empty() ? all_ : range;
  }
  /// The largest: what the query achieves where it looks.
  [[nodiscard]] double error() const { return error_; }

 private:
  Range all_;
  std::vector<Vec3d> corners_;
  std::vector<CellLocator::Cell> boxes_;
  std::vector<Range> ranges_;
  double error_ = 0;
  std::unique_ptr<const CellLocator> locator_;
};

/// Slots of cells of a cut that are where is looked, by their last vertex: near ones are near.
template <typename View>
std::vector<std::uint32_t> slots_near(const View& view, const MeetsBox& where) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
  const auto slots = view.cut().slots();
  for (std::uint32_t slot = 0; slot < slots.size(); ++slot) {
    const auto& cell = slots[slot];
    if (!view.cut().is_inside(cell)) continue;
    Box3d box;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3d p = view.position(cell.corners[k]);
      if (k == 0) box = {p, p};
      for (std::size_t i = 0; i < 3; ++i) {
        box.lower[i] = std::min(box.lower[i], p[i]);
        box.upper[i] = std::max(box.upper[i], p[i]);
      }
    }
    if (where(box)) found.emplace_back(std::ranges::max(cell.corners), slot);
  }
  std::ranges::sort(found);
  std::vector<std::uint32_t> slots_found;
  slots_found.reserve(found.size());
  for (const auto& [vertex, slot] : found) slots_found.push_back(slot);
  return slots_found;
}

template <typename View>
void fill_cells(const View& view, const TetraInfo& info, const std::vector<std::uint32_t>& slots,
                ProbeCells& cells) {
  SimplexMesh& mesh = cells.mesh;
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t slot : slots) {
    const auto& cell = view.cut().slots()[slot];
    mesh.tetrahedra.push_back(cell.corners);
    const std::uint32_t maker = view.maker(slot);
    cells.is_exact.push_back(maker == kNone ? 1 : 0);
    mesh.errors.push_back(maker == kNone ? 0 : view.cut().facts(NodeId{maker}).error);
    if (info.regions.size() > 1) mesh.regions.push_back(info.regions[view.region(slot)].id);
    vertices.insert(vertices.end(), cell.corners.begin(), cell.corners.end());
  }
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  for (const std::uint32_t v : vertices) {
    mesh.positions.push_back(view.position(v));
    mesh.values.push_back(view.value(v));
  }
  for (auto& t : mesh.tetrahedra)
    for (std::uint32_t& v : t)
      v = static_cast<std::uint32_t>(std::ranges::lower_bound(vertices, v) - vertices.begin());
}

/// The cells of a cut that is fine where is looked, and those there only.
template <typename View>
Result<ProbeCells> cells_of(View view, const TetraInfo& info, std::size_t field,
                            const MeetsBox& where, double max_error, Progress& progress,
                            ProbeReport& report) {
  typename View::Cut& cut = view.cut();
  Engine<typename View::Cut> engine(cut);
  engine.set_query(probe_demand(where, max_error, bounds_slack(info.bounds)), {},
                   FocusChange::changed, ApplyOrder::nearest_first);
  engine.run([&] { return progress.is_cancelled() || cut.is_damaged(); });
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(cut.check());
  const Range all{info.fields[field].range_min, info.fields[field].range_max};
  const auto ranges = std::make_shared<const CandidateRanges>(engine, cut, all, info.bounds);
  const ErrorPlace place = info.fields[field].error_place;
  ProbeCells cells{.is_exact_at_vertices = info.placement == Placement::half_edge,
                   .error_place = place};
  // Those, too, whose boundary may be off by as much as to come there.
  const double deviation = info.boundary_deviation;
  const auto near = [&](const Box3d& box) {
    const Vec3d reach{{deviation, deviation, deviation}};
    return where({box.lower - reach, box.upper + reach});
  };
  fill_cells(view, info, slots_near(view, near), cells);
  LODE_CHECK(cut.check());
  cells.range_in = [ranges](const Box3d& box) { return ranges->range_in(box); };
  cells.range_off_cells = [ranges](const Box3d& box) { return ranges->range_of_candidates(box); };
  cells.all = all;
  cells.domain = info.bounds;
  cells.boundary_deviation = deviation;
  report = {.max_error = max_error,
            .achieved_error = ranges->error(),
            .error_place = place,
            .n_cut_cells = engine.standing().n_cells};
  return cells;
}

Result<ProbeCells> cells_near(const ProbedHierarchy& hierarchy, std::size_t field,
                              const MeetsBox& where, double max_error, Progress& progress,
                              ProbeReport& report) {
  const auto look = [&](const auto* found, const auto& view_of) -> Result<ProbeCells> {
    const TetraInfo info = info_of(found->head());
    if (field >= info.fields.size())
      return fail("field: expected a number below {}, got {}", info.fields.size(), field);
    return cells_of(view_of(*found), info, field, where, max_error, progress, report);
  };
  if (const auto* half_edges = std::get_if<const PackedHierarchy*>(&hierarchy))
    return look(*half_edges, [&](const PackedHierarchy& h) { return HalfEdgeView(h, field); });
  return look(std::get<const Forest*>(hierarchy),
              [&](const Forest& forest) { return MidpointView(forest, field); });
}

void count_outside(std::span<const ProbedPoint> points, ProbeReport& report) {
  for (const ProbedPoint& point : points)
    if (!point.is_inside) ++(point.is_near_boundary ? report.n_near_boundary : report.n_outside);
}

}  // namespace

Result<ProbeReport> probe_hierarchy(const ProbedHierarchy& hierarchy, std::span<const Vec3d> points,
                                    const ProbeOptions& options, std::vector<ProbedPoint>& found,
                                    Progress& progress) {
  LODE_CHECK(check_probe(points, options.max_error));
  ProbeReport report;
  LODE_TRY(const ProbeCells cells, cells_near(hierarchy, options.field, meets_points(points),
                                              options.max_error, progress, report));
  found = probe_points_in(cells, points, options.threads);
  count_outside(found, report);
  return report;
}

Result<ProbeReport> probe_hierarchy(const ProbedHierarchy& hierarchy, const ProbedLine& line,
                                    const ProbeOptions& options,
                                    std::vector<ProbedLinePoint>& found, Progress& progress) {
  LODE_CHECK(check_probe({}, options.max_error));
  LODE_CHECK(check_line(line));
  ProbeReport report;
  if (line.n_points > 0) {
    std::vector<ProbedPoint> points;
    LODE_TRY(report, probe_hierarchy(hierarchy, points_on(line), options, points, progress));
    found = on_line(line, points);
    return report;
  }
  LODE_TRY(const ProbeCells cells,
           cells_near(hierarchy, options.field, meets_segment(line.begin, line.end),
                      options.max_error, progress, report));
  found = probe_line_in(cells, line.begin, line.end, options.threads);
  return report;
}

Result<IntegralReport> integrate_hierarchy(const ProbedHierarchy& hierarchy,
                                           const IntegralOptions& options, Progress& progress) {
  LODE_CHECK(check_integral(options));
  ProbeReport probe;
  LODE_TRY(const ProbeCells cells,
           cells_near(hierarchy, options.field, options.box ? meets_box(*options.box) : meets_all(),
                      options.max_error, progress, probe));
  IntegralReport report = integrate_cells(cells, options);
  report.probe = probe;
  return report;
}

}  // namespace lode
