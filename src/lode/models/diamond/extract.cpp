#include "lode/models/diamond/extract.h"

#include <cmath>
#include <memory>
#include <optional>

#include "lode/core/stopwatch.h"
#include "lode/models/diamond/brick_marcher.h"
#include "lode/models/diamond/cube_deviation.h"
#include "lode/models/diamond/full_resolution.h"
#include "lode/models/diamond/join_parts.h"

namespace lode::diamond {
namespace {

template <int D>
Selection<D> selection_of(const Model<D>& model, const IsosurfaceQuery& query) {
  if constexpr (D == 3)
    return Selection<D>(model, query.isovalue, query.cut_tolerance(), query.wanted);
  else
    return Selection<D>(model, query.isovalue, query.cut_tolerance());
}

template <int D>
class Extraction {
 public:
  Extraction(const Model<D>& model, const IsosurfaceQuery& query)
      : model_(model),
        query_(query),
        frame_(LatticeFrame::of(model.info.grid)),
        selection_(selection_of(model, query)) {}

  Result<IsosurfaceReport> run(Surface& surface, Progress& progress) {
    const Stopwatch watch;
    IsosurfaceReport report;
    LODE_CHECK(check_style<D>(query_, model_.shape));
    if constexpr (D == 3)
      if (model_.shape.has_cells() && query_.tolerance == 0 && !model_.has_holes() &&
          std::isinf(query_.style_distance) && query_.weak_of(query_.isovalue) == nullptr)
        return run_flat(selection_, surface, progress);
    if (query_.replaces) surface.clear();
    surface.origin = frame_.surface_origin;
    if (!model_.shape.has_cells()) return report;
    CoarseTraversal<D, Selection<D>>(selection_, cut_).run();
    work_ = work_of(cut_);
    LODE_CHECK(find_cubes(progress));
    march(progress);
    if (progress.is_cancelled()) return cancelled_error();
    const double marched = watch.seconds();
    LODE_CHECK(join_parts(model_, frame_, query_, parts_, parts_of_bricks_, surface));
    LargestSteps largest;
    largest.add(parts_);
    report = report_of(largest, stats_, frame_);
    report.select_seconds = marched;
    report.geometry_seconds = watch.seconds() - marched;
    if (cubes_ && query_.with_deviation) {
      const Stopwatch measuring;
      report.deviation = measure_found();
      report.measure_seconds = measuring.seconds();
    }
    return report;
  }

 private:
  Result<IsosurfaceReport> run_flat(const Selection<3>& selection, Surface& surface,
                                    Progress& progress) {
    LODE_TRY(const auto flat,
             extract_full_resolution(selection, frame_, query_, surface, progress));
    IsosurfaceReport report;
    report.has_isovalues = query_.with_isovalues;
    report.coordinate_slack = slack_of(frame_, flat.largest_step, flat.largest_snap);
    report.nodes_visited = flat.n_bricks_read;
    report.select_seconds = flat.sign_seconds;
    report.geometry_seconds = flat.write_seconds;
    if (query_.style == SurfaceStyle::cubes && query_.with_deviation) {
      const Stopwatch measuring;
      LODE_TRY(report.deviation, measure_cubes(model_, query_, progress));
      report.measure_seconds = measuring.seconds();
    }
    return report;
  }

  Result<void> find_cubes(Progress& progress) {
    if constexpr (D == 3) {
      if (query_.style != SurfaceStyle::cubes) return {};
      for (const BrickWork<D>& work : work_)
        bricks_.push_back(cut_brick<D>(cut_, model_.brick_dims, work));
      LODE_TRY(cubes_, CubeCells::find(selection_, bricks_, frame_, query_.style_limit(),
                                       query_.weak_of(query_.isovalue), query_.threads, progress));
    }
    return {};
  }
  [[nodiscard]] CubeDeviation measure_found() const {
    CubeDeviation deviation;
    if constexpr (D == 3) deviation = cubes_->measure(selection_, bricks_, frame_, query_.threads);
    deviation.distance = std::max(deviation.distance, farthest_move_);
    return deviation;
  }

  void march(Progress& progress) {
    parts_.resize(work_.size() + 1);
    march_coarse<D>(cut_, query_.isovalue, model_.axes, frame_, parts_[0]);
    leave_out_weak(parts_[0]);
    std::vector<TraversalStats> stats(work_.size());
    std::vector<std::unique_ptr<BrickMarcher<D>>> workers(as_size(n_workers(query_.threads)));
    parallel_for(work_.size(), query_.threads, 1, [&](std::size_t i, int worker) {
      if (progress.is_cancelled()) return;
      auto& own = workers[as_size(worker)];
      if (!own) {
        own = std::make_unique<BrickMarcher<D>>(std::span(&selection_, 1), frame_);
        if (cubes_) own->set_cubes(std::span(&*cubes_, 1));
      }
      march_brick(*own, i, stats[i]);
    });
    for (const auto& worker : workers)
      if (worker) farthest_move_ = std::max(farthest_move_, worker->farthest_move());
    stats_ = cut_.stats;
    for (const TraversalStats& s : stats) stats_.join(s);
    parts_of_bricks_ = PartsOfBricks<D>(model_.axes, model_.brick_dims, work_);
  }

  void march_brick(BrickMarcher<D>& marcher, std::size_t i, TraversalStats& stats) {
    const CutBrick<D> brick = cut_brick<D>(cut_, model_.brick_dims, work_[i]);
    std::vector<BrickPiece<D>> pieces;
    marcher.march(
        {brick.brick, {}, model_.axes}, brick.simplices, [](std::size_t) { return true; }, stats,
        pieces);
    if (pieces.empty()) return;
    parts_[i + 1] = std::move(pieces.front().part);
    leave_out_weak(parts_[i + 1]);
  }

  void leave_out_weak(StitchPart<D>& part) const {
    if constexpr (D == 3)
      if (const auto* const weak = query_.weak_of(query_.isovalue); weak != nullptr)
        leave_out(*weak, model_.axes, part);
  }

  const Model<D>& model_;
  IsosurfaceQuery query_;
  LatticeFrame frame_;
  Selection<D> selection_;
  CoarseCut<D> cut_;
  std::vector<BrickWork<D>> work_;
  std::vector<CutBrick<D>> bricks_;  ///< The same, in the style of cubes,
  std::optional<CubeCells> cubes_;   ///< and which cells of them are cubes.
  double farthest_move_ = 0;
  std::vector<StitchPart<D>> parts_;  ///< Everything coarser, then one per brick of work_.
  PartsOfBricks<D> parts_of_bricks_;
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
  const Selection<D> selection = selection_of(model, query);
  CoarseCut<D> cut;
  if (!model.shape.has_cells()) return {};
  CoarseTraversal<D, Selection<D>>(selection, cut).run();
  std::vector<ActiveSimplex<D>> result = cut.leaves;
  BrickTraversal<D> traversal(selection);
  TraversalStats stats;
  for (const BrickWork<D>& work : work_of(cut)) {
    traversal.open(point_of<D>(model.brick_dims, work.brick));
    for (std::size_t s = work.begin; s < work.end; ++s)
      traversal.visit(cut.brick_simplices[s].second, stats, [&](const BrickSimplex<D>& leaf) {
        ActiveSimplex<D>& active = result.emplace_back();
        for (std::size_t i = 0; i <= as_size(D); ++i) {
          active.vertex[i] = traversal.samples().global(leaf.corner[i].packed);
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
