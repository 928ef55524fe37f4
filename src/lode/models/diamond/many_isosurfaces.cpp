// Several isovalues' surfaces out of one traversal of a model in memory.
#include <algorithm>
#include <memory>
#include <utility>

#include "lode/core/stopwatch.h"
#include "lode/models/diamond/brick_marcher.h"
#include "lode/models/diamond/extract.h"
#include "lode/models/diamond/join_parts.h"

namespace lode::diamond {
namespace {

template <int D>
class ManyExtraction {
 public:
  ManyExtraction(const Model<D>& model, const IsovalueList& isovalues, const IsosurfaceQuery& query)
      : model_(model),
        isovalues_(isovalues),
        query_(query),
        frame_(LatticeFrame::of(model.info.grid)),
        selection_(model, isovalues, query.tolerance),
        is_wanted_(isovalues.size(), 1) {}

  /// The parts of all surfaces.
  Result<void> march(Progress& progress) {
    if (!model_.shape.has_cells()) return {};
    CoarseTraversal<D, ManySelection<D>>(selection_, cut_).run();
    work_ = work_of(cut_);
    pieces_.resize(work_.size());
    std::vector<TraversalStats> stats(work_.size());
    std::vector<std::unique_ptr<ManyMarcher<D>>> workers(as_size(n_workers(query_.threads)));
    parallel_for(work_.size(), query_.threads, 1, [&](std::size_t i, int number) {
      if (progress.is_cancelled()) return;
      auto& worker = workers[as_size(number)];
      if (!worker) worker = std::make_unique<ManyMarcher<D>>(selection_, isovalues_, frame_);
      march_brick(*worker, i, stats[i]);
    });
    if (progress.is_cancelled()) return cancelled_error();
    stats_ = cut_.stats;
    for (const TraversalStats& s : stats) stats_.join(s);
    return {};
  }

  /// Appends one of the surfaces, whose parts are used up.
  Result<void> join(std::size_t isovalue, Surface& surface) {
    std::vector<StitchPart<D>> parts(1);
    march_coarse<D>(cut_, isovalues_[isovalue], model_.axes, frame_, parts[0]);
    std::vector<BrickWork<D>> work;
    for (std::size_t i = 0; i < work_.size(); ++i)
      for (BrickPiece<D>& piece : pieces_[i])
        if (piece.isovalue == isovalue) {
          work.push_back(work_[i]);
          parts.push_back(std::exchange(piece.part, {}));
        }
    LargestSteps largest;
    largest.add(parts);
    slack_ = std::max(slack_, slack_of(frame_, largest.step, largest.snap));
    const PartsOfBricks<D> of_bricks(model_.axes, model_.brick_dims, work);
    return join_parts(model_, frame_, query_, parts, of_bricks, surface);
  }
  /// All but the seconds.
  [[nodiscard]] IsosurfaceReport report() const {
    IsosurfaceReport report = report_of({}, stats_, frame_);
    report.coordinate_slack = slack_;
    return report;
  }
  [[nodiscard]] const LatticeFrame& frame() const { return frame_; }

 private:
  void march_brick(ManyMarcher<D>& marcher, std::size_t i, TraversalStats& stats) {
    marcher.march(
        {point_of<D>(model_.brick_dims, work_[i].brick), {}, model_.axes, is_wanted_},
        [&](const auto& visit) {
          for (std::size_t s = work_[i].begin; s < work_[i].end; ++s)
            visit(cut_.brick_simplices[s].second);
        },
        stats, pieces_[i]);
  }

  const Model<D>& model_;
  const IsovalueList& isovalues_;
  const IsosurfaceQuery& query_;
  LatticeFrame frame_;
  ManySelection<D> selection_;
  std::vector<std::uint8_t> is_wanted_;  ///< All.
  CoarseCut<D> cut_;
  std::vector<BrickWork<D>> work_;
  std::vector<std::vector<BrickPiece<D>>> pieces_;  ///< By work.
  TraversalStats stats_;
  double slack_ = 0;  ///< The largest of all surfaces'.
};

template <int D>
Result<IsosurfaceReport> extract_some(const Model<D>& model, std::span<const double> isovalues,
                                      const IsosurfaceQuery& query,
                                      const std::function<void(double)>& after, Surface& surface,
                                      Progress& progress) {
  const Stopwatch watch;
  const IsovalueList list = IsovalueList::of(isovalues);
  ManyExtraction<D> extraction(model, list, query);
  surface.origin = extraction.frame().surface_origin;
  LODE_CHECK(extraction.march(progress));
  const double marched = watch.seconds();
  for (const double isovalue : isovalues) {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_CHECK(extraction.join(list.rank(isovalue) - 1, surface));
    after(isovalue);
  }
  IsosurfaceReport report = extraction.report();
  report.select_seconds = marched;
  report.geometry_seconds = watch.seconds() - marched;
  return report;
}

}  // namespace

template <int D>
bool shares_traversal(const Model<D>& model, const IsosurfaceQuery& query) {
  const bool reads_signs = D == 3 && query.tolerance == 0 && !model.has_holes();
  return !reads_signs && query.style == SurfaceStyle::tetra && query.wanted == nullptr;
}

template <int D>
Result<IsosurfaceReport> extract_isosurfaces(const Model<D>& model,
                                             std::span<const double> isovalues,
                                             const IsosurfaceQuery& query,
                                             const std::function<void(double)>& after,
                                             Surface& surface, Progress& progress) {
  LODE_EXPECTS(shares_traversal(model, query) && !query.replaces);
  constexpr std::size_t kAtOnce = 8;
  IsosurfaceReport report;
  for (std::size_t first = 0; first < isovalues.size(); first += kAtOnce) {
    const auto some = isovalues.subspan(first, std::min(kAtOnce, isovalues.size() - first));
    LODE_TRY(const auto part, extract_some(model, some, query, after, surface, progress));
    report.achieved_error = std::max(report.achieved_error, part.achieved_error);
    report.coordinate_slack = std::max(report.coordinate_slack, part.coordinate_slack);
    report.nodes_visited += part.nodes_visited;
    report.select_seconds += part.select_seconds;
    report.geometry_seconds += part.geometry_seconds;
  }
  return report;
}

template bool shares_traversal<2>(const Model<2>&, const IsosurfaceQuery&);
template bool shares_traversal<3>(const Model<3>&, const IsosurfaceQuery&);
template Result<IsosurfaceReport> extract_isosurfaces<2>(const Model<2>&, std::span<const double>,
                                                         const IsosurfaceQuery&,
                                                         const std::function<void(double)>&,
                                                         Surface&, Progress&);
template Result<IsosurfaceReport> extract_isosurfaces<3>(const Model<3>&, std::span<const double>,
                                                         const IsosurfaceQuery&,
                                                         const std::function<void(double)>&,
                                                         Surface&, Progress&);

}  // namespace lode::diamond
