#include "lode/models/diamond/extract.h"

#include <chrono>
#include <memory>

#include "lode/mappers/simplex_isosurface.h"
#include "lode/mappers/stitch.h"
#include "lode/models/diamond/brick_isosurface.h"
#include "lode/models/diamond/full_resolution.h"
#include "lode/models/diamond/normals.h"

namespace lode::diamond {
namespace {

/// The part of the cut above brick size, and which brick-size simplices it was refined down to.
template <int D>
struct CoarseCut {
  std::vector<ActiveSimplex<D>> leaves;
  std::vector<std::pair<std::size_t, Simplex<D>>> brick_simplices;  ///< By brick, ascending.
  TraversalStats stats;
};

template <int D>
class CoarseTraversal {
 public:
  CoarseTraversal(const Selection<D>& selection, CoarseCut<D>& out)
      : selection_(selection), out_(out) {}

  void run() {
    const std::int32_t root = selection_.model().shape.root_side();
    for (const Simplex<D>& s : kuhn_simplices<D>({}, root)) visit(s);
    std::stable_sort(out_.brick_simplices.begin(), out_.brick_simplices.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
  }

 private:
  void visit(const Simplex<D>& s) {
    const Model<D>& model = selection_.model();
    const LatticeBox<D> box = bounds_of(s);
    if (!model.shape.overlaps_data(box)) return;
    if (s.tag == D && box.edge(0) <= kBrickEdge<D>) {
      Index<D> brick;
      for (std::size_t i = 0; i < as_size(D); ++i) brick[i] = box.lower[i] / kBrickEdge<D>;
      out_.brick_simplices.emplace_back(linear_index<D>(model.brick_dims, brick), s);
      return;
    }
    ++out_.stats.nodes_visited;
    const Diamond<D> d = diamond_at<D>(s.bisection_point());
    const std::size_t at = selection_.index_of(d);
    if (!selection_.is_active(d.level, at)) return;
    if (selection_.exceeds_tolerance(selection_.error(d.level, at)) ||
        model.shape.reaches_across(d.centre, d.level)) {
      for (const Simplex<D>& half : bisect(s)) visit(half);
      return;
    }
    add_leaf(s, selection_.error(d.level, at));
  }

  void add_leaf(const Simplex<D>& s, ErrorCode error) {
    const Model<D>& model = selection_.model();
    ActiveSimplex<D> leaf;
    leaf.vertex = s.v;
    int n_inside = 0;
    for (std::size_t i = 0; i <= as_size(D); ++i) {
      leaf.value[i] = model.value_or_nan(s.v[i]);
      if (std::isnan(leaf.value[i])) return;
      n_inside += leaf.value[i] >= selection_.isovalue() ? 1 : 0;
    }
    if (n_inside == 0 || n_inside == D + 1) return;
    if (model.has_holes() && model.is_removed(s)) return;
    out_.leaves.push_back(leaf);
    out_.stats.achieved = std::max(out_.stats.achieved, error);
  }

  const Selection<D>& selection_;
  CoarseCut<D>& out_;
};

template <int D>
LatticeSimplex<D> to_lattice(const AxisMap<D>& axes,
                             const std::array<Index<D>, as_size(D) + 1>& vertex,
                             const std::array<double, as_size(D) + 1>& value) {
  LatticeSimplex<D> s;
  for (std::size_t i = 0; i <= as_size(D); ++i) s.vertex[i] = to_key(axes.to_grid(vertex[i]));
  s.value = value;
  return s;
}

/// Brick simplices as ranges, one per brick that has any.
template <int D>
struct BrickWork {
  std::size_t brick, begin, end;
};

template <int D>
std::vector<BrickWork<D>> work_of(const CoarseCut<D>& cut) {
  std::vector<BrickWork<D>> work;
  for (std::size_t i = 0; i < cut.brick_simplices.size(); ++i) {
    if (work.empty() || work.back().brick != cut.brick_simplices[i].first)
      work.push_back({cut.brick_simplices[i].first, i, i});
    work.back().end = i + 1;
  }
  return work;
}

/// Whether a vertex on this edge may belong to a part other than the brick with lower corner
/// `base`: its midpoint is on the brick's border, or the edge joins two of its corners.
template <int D>
bool is_on_brick_border(const AxisMap<D>& axes, const EdgePoint& point) {
  const Index3 a = to_point(point.first);
  const Index3 b = to_point(point.second);
  bool joins_corners = true;
  for (const int axis : axes.axis) {
    const auto i = as_size(axis);
    if ((a[i] + b[i]) % (2 * kBrickEdge<D>) == 0) return true;
    joins_corners = joins_corners && a[i] % kBrickEdge<D> == 0 && b[i] % kBrickEdge<D> == 0;
  }
  return joins_corners;
}

template <int D>
class Extraction {
 public:
  Extraction(const Model<D>& model, const IsosurfaceQuery& query)
      : model_(model),
        query_(query),
        frame_(LatticeFrame::of(model.info.grid)),
        selection_(model, query.isovalue, query.tolerance) {}

  Result<IsosurfaceReport> run(Surface& surface, Progress& progress) {
    const auto start = std::chrono::steady_clock::now();
    IsosurfaceReport report;
    if constexpr (D == 3)
      if (model_.shape.has_cells() && query_.tolerance == 0 && !model_.has_holes())
        return run_flat(selection_, surface, progress);
    if (query_.replaces) surface.clear();
    surface.origin = frame_.surface_origin;
    if (!model_.shape.has_cells()) return report;
    CoarseTraversal<D>(selection_, cut_).run();
    march(progress);
    if (progress.is_cancelled()) return cancelled_error();
    const auto marched = std::chrono::steady_clock::now();
    std::vector<VertexOrigin> origins;
    const std::size_t first_new = surface.positions.size();
    LODE_CHECK(stitch<D>(
        parts_, [&](LatticeKey key, std::vector<std::uint32_t>& out) { candidates(key, out); },
        frame_, query_.threads, surface, query_.with_normals ? &origins : nullptr));
    if (query_.with_normals) {
      std::vector<EdgePoint> points(surface.positions.size() - first_new);
      for (std::size_t v = first_new; v < origins.size(); ++v)
        points[v - first_new] = parts_[origins[v].part].part.points[origins[v].vertex];
      surface.normals.resize(surface.positions.size());
      compute_normals<D>(model_, points, query_.threads,
                         std::span(surface.normals).subspan(first_new));
    }
    fill(report);
    const auto done = std::chrono::steady_clock::now();
    report.select_seconds = std::chrono::duration<double>(marched - start).count();
    report.geometry_seconds = std::chrono::duration<double>(done - marched).count();
    return report;
  }

 private:
  struct Worker {
    explicit Worker(const Extraction& e)
        : traversal(e.selection_), mapper(e.frame_, e.query_.isovalue) {}

    BrickTraversal<D> traversal;
    BrickIsosurface<D> mapper;
  };

  Result<IsosurfaceReport> run_flat(const Selection<3>& selection, Surface& surface,
                                    Progress& progress) {
    LODE_TRY(const auto flat,
             extract_full_resolution(selection, frame_, query_, surface, progress));
    IsosurfaceReport report;
    report.coordinate_slack = slack(flat.largest_step, flat.largest_snap);
    report.nodes_visited = flat.n_bricks_read;
    report.select_seconds = flat.sign_seconds;
    report.geometry_seconds = flat.write_seconds;
    return report;
  }

  void march(Progress& progress) {
    work_ = work_of(cut_);
    parts_.resize(work_.size() + 1);
    {
      SimplexIsosurface<D> mapper(frame_, query_.isovalue, parts_[0].part);
      for (const ActiveSimplex<D>& s : cut_.leaves)
        mapper.add(to_lattice<D>(model_.axes, s.vertex, s.value));
      find_shared<D>(parts_[0], [](const EdgePoint&) { return true; });
    }
    std::vector<TraversalStats> stats(work_.size());
    std::vector<std::unique_ptr<Worker>> workers(as_size(n_workers(query_.threads)));
    parallel_for(work_.size(), query_.threads, 1, [&](std::size_t i, int worker) {
      if (progress.is_cancelled()) return;
      auto& own = workers[as_size(worker)];
      if (!own) own = std::make_unique<Worker>(*this);
      march_brick(*own, i, stats[i]);
    });
    stats_ = cut_.stats;
    for (const TraversalStats& s : stats) stats_.join(s);
    part_of_brick_.assign(model_.n_bricks(), 0);
    for (std::size_t i = 0; i < work_.size(); ++i)
      part_of_brick_[work_[i].brick] = static_cast<std::uint32_t>(i + 1);
  }

  void march_brick(Worker& worker, std::size_t i, TraversalStats& stats) {
    const Index<D> brick = point_of<D>(model_.brick_dims, work_[i].brick);
    worker.traversal.open(brick);
    worker.mapper.open(worker.traversal, model_.axes, parts_[i + 1].part);
    for (std::size_t s = work_[i].begin; s < work_[i].end; ++s)
      worker.traversal.visit(cut_.brick_simplices[s].second, stats,
                             [&](const BrickSimplex<D>& leaf) { worker.mapper.add(leaf); });
    find_shared<D>(parts_[i + 1],
                   [&](const EdgePoint& p) { return is_on_brick_border<D>(model_.axes, p); });
  }

  /// The parts whose closed region contains a doubled midpoint: the coarse one, and up to 2^D
  /// bricks. Part i + 1 is brick work_[i].
  void candidates(LatticeKey key, std::vector<std::uint32_t>& out) const {
    const Index3 doubled = to_point(key);
    out.push_back(0);
    for (int corner = 0; corner < (1 << D); ++corner) {
      Index<D> brick;
      bool exists = true;
      for (int i = 0; i < D; ++i) {
        const std::int32_t x = doubled[as_size(model_.axes.axis[as_size(i)])];
        const bool lower = ((corner >> i) & 1) == 0;
        brick[as_size(i)] = x / (2 * kBrickEdge<D>)-(lower ? 1 : 0);
        exists = exists && (!lower || x % (2 * kBrickEdge<D>) == 0) && brick[as_size(i)] >= 0 &&
                 brick[as_size(i)] < model_.brick_dims[as_size(i)];
      }
      if (!exists) continue;
      const std::uint32_t part = part_of_brick_[linear_index<D>(model_.brick_dims, brick)];
      if (part != 0) out.push_back(part);
    }
    std::sort(out.begin(), out.end());
  }

  void fill(IsosurfaceReport& report) const {
    report.achieved_error = static_cast<double>(decode_error(stats_.achieved));
    report.nodes_visited = stats_.nodes_visited;
    double largest_step = 0;
    double largest_snap = 0;
    for (const StitchPart<D>& part : parts_) {
      largest_step = std::max(largest_step, part.part.largest_step);
      largest_snap = std::max(largest_snap, part.part.largest_snap);
    }
    report.coordinate_slack = slack(largest_step, largest_snap);
  }

  /// What margin and rounding may add to |F - isovalue|. Margin: along its edge. Rounding: up to
  /// half a unit along each axis, where the field changes by at most twice the simplex's range a
  /// step.
  [[nodiscard]] double slack(double largest_step, double largest_snap) const {
    return frame_.margin * largest_snap + 4 * frame_.rounding * largest_step;
  }

  const Model<D>& model_;
  IsosurfaceQuery query_;
  LatticeFrame frame_;
  Selection<D> selection_;
  CoarseCut<D> cut_;
  std::vector<BrickWork<D>> work_;
  std::vector<StitchPart<D>> parts_;          ///< Everything coarser, then one per brick of work_.
  std::vector<std::uint32_t> part_of_brick_;  ///< 0: none.
  TraversalStats stats_;
};

}  // namespace

template <int D>
Result<IsosurfaceReport> extract_isosurface(const Model<D>& model, const IsosurfaceQuery& query,
                                            Surface& surface, Progress& progress) {
  return Extraction<D>(model, query).run(surface, progress);
}

template <int D>
std::vector<ActiveSimplex<D>> active_simplices(const Model<D>& model,
                                               const IsosurfaceQuery& query) {
  const Selection<D> selection(model, query.isovalue, query.tolerance);
  CoarseCut<D> cut;
  if (!model.shape.has_cells()) return {};
  CoarseTraversal<D>(selection, cut).run();
  std::vector<ActiveSimplex<D>> result = cut.leaves;
  BrickTraversal<D> traversal(selection);
  TraversalStats stats;
  for (const BrickWork<D>& work : work_of(cut)) {
    traversal.open(point_of<D>(model.brick_dims, work.brick));
    for (std::size_t s = work.begin; s < work.end; ++s)
      traversal.visit(cut.brick_simplices[s].second, stats, [&](const BrickSimplex<D>& leaf) {
        ActiveSimplex<D>& active = result.emplace_back();
        for (std::size_t i = 0; i <= as_size(D); ++i) {
          active.vertex[i] = traversal.global(leaf.corner[i].packed);
          active.value[i] = leaf.corner[i].value;
        }
      });
  }
  return result;
}

template Result<IsosurfaceReport> extract_isosurface<2>(const Model<2>&, const IsosurfaceQuery&,
                                                        Surface&, Progress&);
template Result<IsosurfaceReport> extract_isosurface<3>(const Model<3>&, const IsosurfaceQuery&,
                                                        Surface&, Progress&);
template std::vector<ActiveSimplex<2>> active_simplices<2>(const Model<2>&, const IsosurfaceQuery&);
template std::vector<ActiveSimplex<3>> active_simplices<3>(const Model<3>&, const IsosurfaceQuery&);

}  // namespace lode::diamond
