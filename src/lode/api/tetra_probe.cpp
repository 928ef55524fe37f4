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
#include "lode/api/tetra_query.h"
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
      : hierarchy_(hierarchy), cut_(hierarchy, field) {}

  [[nodiscard]] Cut& cut() { return cut_; }
  [[nodiscard]] const Cut& cut() const { return cut_; }
  [[nodiscard]] Vec3d position(std::uint32_t vertex) const { return hierarchy_.position(vertex); }
  [[nodiscard]] Result<std::vector<double>> values(std::span<const std::uint32_t> vertices,
                                                   std::size_t field) const {
    std::vector<double> all;
    all.reserve(vertices.size());
    for (const std::uint32_t v : vertices) all.push_back(hierarchy_.value(v, field));
    return all;
  }
  [[nodiscard]] StoredFacts facts(NodeId node, std::size_t field) const {
    return hierarchy_.facts(static_cast<std::uint32_t>(node), field);
  }
  [[nodiscard]] double range_reference(std::size_t field) const {
    return hierarchy_.head().fields[field].low;
  }
  [[nodiscard]] std::uint32_t maker(std::uint32_t slot) const { return cut_.maker(slot); }
  [[nodiscard]] std::uint32_t region(std::uint32_t slot) const { return cut_.region(slot); }

 private:
  const PackedHierarchy& hierarchy_;
  Cut cut_;
};

class MidpointView {
 public:
  using Cut = MidpointCut;

  MidpointView(const Forest& forest, std::size_t field) : cut_(forest, field) {}

  [[nodiscard]] Cut& cut() { return cut_; }
  [[nodiscard]] const Cut& cut() const { return cut_; }
  [[nodiscard]] Vec3d position(std::uint32_t vertex) const { return cut_.position(vertex); }
  [[nodiscard]] Result<std::vector<double>> values(std::span<const std::uint32_t> vertices,
                                                   std::size_t field) const {
    return cut_.values(vertices, field);
  }
  [[nodiscard]] StoredFacts facts(NodeId node, std::size_t field) const {
    return cut_.facts(node, field);
  }
  [[nodiscard]] double range_reference(std::size_t field) const {
    return cut_.head().fields[field].codes.knots()[0];
  }
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
/// the cut's cell there is the reference's. Of queries for regions this holds in these.
class CandidateRanges {
 public:
  /// `fields`: the cut's first.
  template <typename View>
  CandidateRanges(const Engine<typename View::Cut>& engine, const View& view, const TetraInfo& info,
                  std::span<const std::size_t> fields)
      : of_fields_(fields.size()) {
    const Cut& nodes = engine.cut();
    const double slack = bounds_slack(info.bounds);
    for (std::size_t f = 0; f < fields.size(); ++f)
      of_fields_[f].all = {info.fields[fields[f]].range_min, info.fields[fields[f]].range_max};
    for (std::size_t at = 0; at < nodes.n_places(); ++at) {
      const Cut::Entry& entry = nodes[static_cast<Cut::Place>(at)];
      if (entry.state != Cut::State::candidate) continue;
      const Box3d box = box_of(view.cut().bounds(entry.id), slack);
      const auto first = static_cast<std::uint32_t>(corners_.size());
      corners_.insert(corners_.end(), {box.lower, box.upper});
      boxes_.push_back({first, first + 1, first, first + 1});
      for (std::size_t f = 0; f < fields.size(); ++f) {
        const StoredFacts facts = f == 0 ? entry.facts() : view.facts(entry.id, fields[f]);
        OfField& field = of_fields_[f];
        field.ranges.push_back(without_bounds(facts, view.range_reference(fields[f])).range);
        field.error = std::max(field.error, static_cast<double>(facts.error));
      }
    }
    locator_ = std::make_unique<const CellLocator>(corners_, boxes_, Threads{1});
  }

  /// Of the f-th field; empty where no candidate's bounds are.
  [[nodiscard]] Range range_of_candidates(std::size_t f, const Box3d& where) const {
    const OfField& field = of_fields_[f];
    Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    const auto meets = [&](const Box3d& box) {
      bool is = true;
      for (std::size_t i = 0; i < 3; ++i)
        is = is && box.lower[i] <= where.upper[i] && where.lower[i] <= box.upper[i];
      return is;
    };
    locator_->visit_where(meets, [&](std::uint32_t at) {
      range.low = std::min(range.low, field.ranges[at].low);
      range.high = std::max(range.high, field.ranges[at].high);
    });
    if (range.is_empty()) return range;
    return {std::max(range.low, field.all.low), std::min(range.high, field.all.high)};
  }
  [[nodiscard]] Range range_in(std::size_t f, const Box3d& where) const {
    const Range range = range_of_candidates(f, where);
    return range.is_empty() ? of_fields_[f].all : range;
  }
  /// The largest: what the query achieves where it looks.
  [[nodiscard]] double error(std::size_t f) const { return of_fields_[f].error; }
  [[nodiscard]] const Range& all(std::size_t f) const { return of_fields_[f].all; }

 private:
  struct OfField {
    Range all;
    std::vector<Range> ranges{};  ///< By candidate.
    double error = 0;
  };

  std::vector<OfField> of_fields_;
  std::vector<Vec3d> corners_;
  std::vector<CellLocator::Cell> boxes_;
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

/// What boundaries of cuts may be off by: as far as was measured, and rounding. Of midpoints what
/// was measured starts from the reference's vertices rounded to steps, by up to 2^-31 of the box
/// along each axis (midpoint/codes.h); of half edges only what is reckoned here is rounded.
double deviation_of(const TetraInfo& info) {
  const double diagonal = length(info.bounds.upper - info.bounds.lower);
  const double steps = info.placement == Placement::midpoint ? 0x1p-31 * diagonal : 0;
  return (info.boundary_deviation + steps) * (1 + 1e-6) + distance_rounding(info.bounds);
}

/// Cells without values.
template <typename View>
ProbeCells bare_cells(const View& view, const TetraInfo& info,
                      const std::vector<std::uint32_t>& slots,
                      std::vector<std::uint32_t>& vertices) {
  ProbeCells cells{.is_exact_at_vertices = info.placement == Placement::half_edge};
  SimplexMesh& mesh = cells.mesh;
  for (const std::uint32_t slot : slots) {
    const auto& cell = view.cut().slots()[slot];
    mesh.tetrahedra.push_back(cell.corners);
    cells.is_exact.push_back(view.maker(slot) == kNone ? 1 : 0);
    if (info.regions.size() > 1) mesh.regions.push_back(info.regions[view.region(slot)].id);
    vertices.insert(vertices.end(), cell.corners.begin(), cell.corners.end());
  }
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  for (const std::uint32_t v : vertices) mesh.positions.push_back(view.position(v));
  for (auto& t : mesh.tetrahedra)
    for (std::uint32_t& v : t)
      v = static_cast<std::uint32_t>(std::ranges::lower_bound(vertices, v) - vertices.begin());
  cells.domain = info.bounds;
  cells.boundary_deviation = deviation_of(info);
  cells.rounding = distance_rounding(info.bounds);
  return cells;
}

/// What is looked for.
struct ProbeFocus {
  std::span<const std::size_t> fields;  ///< The first one's is the tolerance.
  MeetsBox where;
  std::span<const std::int64_t> regions{};  ///< Empty: all.
  double max_error = 0;
  double snap = 0;  ///< As ProbeOptions'.
};

/// The cells of a cut that is fine where is looked, and those there only, by field: all have the
/// same ones, of whatever regions.
template <typename View>
Result<std::vector<ProbeCells>> cells_of(View view, const TetraInfo& info, const ProbeFocus& focus,
                                         Progress& progress, ProbeReport& report) {
  const std::span<const std::size_t> fields = focus.fields;
  const double snap =
      std::max(focus.snap, ProbeOptions::kSnapRounding * farthest_corner(info.bounds));
  const MeetsBox where = widened(focus.where, snap);
  typename View::Cut& cut = view.cut();
  Engine<typename View::Cut> engine(cut);
  engine.set_query(in_regions(probe_demand(where, focus.max_error, bounds_slack(info.bounds)), info,
                              focus.regions),
                   {}, FocusChange::changed, ApplyOrder::nearest_first);
  engine.run([&] { return progress.is_cancelled() || cut.is_damaged(); });
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(cut.check());
  const auto ranges = std::make_shared<const CandidateRanges>(engine, view, info, fields);
  // Those, too, whose boundary may be off by as much as to come there.
  const std::vector<std::uint32_t> slots = slots_near(view, widened(where, deviation_of(info)));
  std::vector<std::uint32_t> vertices;
  ProbeCells shape = bare_cells(view, info, slots, vertices);
  shape.snap = snap;
  std::vector<ProbeCells> made(fields.size() - 1, shape);
  made.push_back(std::move(shape));
  report = {.max_error = focus.max_error,
            .achieved_error = ranges->error(0),
            .error_place = info.fields[fields[0]].error_place,
            .n_cut_cells = engine.standing().n_cells};
  for (std::size_t f = 0; f < fields.size(); ++f) {
    ProbeCells& cells = made[f];
    for (const std::uint32_t slot : slots) {
      const std::uint32_t maker = view.maker(slot);
      cells.mesh.errors.push_back(maker == kNone ? 0 : view.facts(NodeId{maker}, fields[f]).error);
    }
    LODE_TRY(cells.mesh.values, view.values(vertices, fields[f]));
    cells.range_in = [ranges, f](const Box3d& box) { return ranges->range_in(f, box); };
    cells.range_off_cells = [ranges, f](const Box3d& box) {
      return ranges->range_of_candidates(f, box);
    };
    cells.all = ranges->all(f);
    cells.error_place = info.fields[fields[f]].error_place;
    if (f > 0) report.along.push_back({ranges->error(f), cells.error_place});
  }
  LODE_CHECK(cut.check());
  return made;
}

/// The field, and further ones.
template <typename Options>
std::vector<std::size_t> fields_of(const Options& options) {
  std::vector<std::size_t> fields{options.field};
  fields.insert(fields.end(), options.along.begin(), options.along.end());
  return fields;
}

Result<std::vector<ProbeCells>> cells_near(const ProbedHierarchy& hierarchy,
                                           const ProbeFocus& focus, Progress& progress,
                                           ProbeReport& report) {
  const auto look = [&](const auto* found, const auto& view_of) -> Result<std::vector<ProbeCells>> {
    const TetraInfo info = info_of(found->head());
    for (const std::size_t field : focus.fields)
      if (field >= info.fields.size())
        return fail("field: expected a number below {}, got {}", info.fields.size(), field);
    return cells_of(view_of(*found), info, focus, progress, report);
  };
  if (const auto* half_edges = std::get_if<const PackedHierarchy*>(&hierarchy))
    return look(*half_edges,
                [&](const PackedHierarchy& h) { return HalfEdgeView(h, focus.fields.front()); });
  return look(std::get<const Forest*>(hierarchy),
              [&](const Forest& forest) { return MidpointView(forest, focus.fields.front()); });
}

/// Of a point that is in the same cell.
void add_along(const ProbedPoint& more, ProbedPoint& point) {
  point.along.push_back({more.value, more.error});
}

}  // namespace

Result<ProbeReport> probe_hierarchy(const ProbedHierarchy& hierarchy, std::span<const Vec3d> points,
                                    const ProbeOptions& options, std::vector<ProbedPoint>& found,
                                    Progress& progress) {
  LODE_CHECK(check_probe(points, options.max_error));
  LODE_CHECK(check_snap(options.snap));
  const std::vector<std::size_t> fields = fields_of(options);
  ProbeReport report;
  LODE_TRY(const std::vector<ProbeCells> cells, cells_near(hierarchy,
                                                           {.fields = fields,
                                                            .where = meets_points(points),
                                                            .max_error = options.max_error,
                                                            .snap = options.snap},
                                                           progress, report));
  found = probe_points_in(cells.front(), points, options.threads);
  for (const ProbeCells& more : std::span(cells).subspan(1)) {
    const std::vector<ProbedPoint> values = probe_points_in(more, points, options.threads);
    for (std::size_t i = 0; i < found.size(); ++i) add_along(values[i], found[i]);
  }
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
  const std::vector<std::size_t> fields = fields_of(options);
  LODE_TRY(const std::vector<ProbeCells> cells,
           cells_near(hierarchy,
                      {.fields = fields,
                       .where = meets_segment(line.begin, line.end),
                       .max_error = options.max_error},
                      progress, report));
  found = probe_line_in(cells.front(), line.begin, line.end, options.threads);
  for (const ProbeCells& more : std::span(cells).subspan(1)) {
    const std::vector<ProbedLinePoint> values =
        probe_line_in(more, line.begin, line.end, options.threads);
    LODE_EXPECTS(values.size() == found.size());
    for (std::size_t i = 0; i < found.size(); ++i) add_along(values[i].at, found[i].at);
  }
  return report;
}

Result<IntegralReport> integrate_hierarchy(const ProbedHierarchy& hierarchy,
                                           const IntegralOptions& options, Progress& progress) {
  LODE_CHECK(check_integral(options));
  ProbeReport probe;
  const std::vector<std::size_t> fields = fields_of(options);
  LODE_TRY(const std::vector<ProbeCells> cells,
           cells_near(hierarchy,
                      {.fields = fields,
                       .where = options.box ? meets_box(*options.box) : meets_all(),
                       .regions = options.regions,
                       .max_error = options.max_error},
                      progress, probe));
  IntegralReport report = integrate_cells(cells.front(), options);
  for (const ProbeCells& more : std::span(cells).subspan(1)) {
    const IntegralReport of = integrate_cells(more, options);
    report.along.push_back(
        {of.integral, of.mean, of.minimum, of.maximum, of.integral_rounding, of.integral_estimate});
  }
  report.probe = probe;
  return report;
}

}  // namespace lode
