#include "lode/models/diamond/isovalue_counts.h"

#include <memory>

#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/full_resolution_counts.h"
#include "lode/models/diamond/leaf_counter.h"

namespace lode::diamond {
namespace {

/// The leaves of the one cut that all isovalues have their surfaces in.
template <int D>
class LeafCounts {
 public:
  LeafCounts(const Model<D>& model, const IsovalueList& isovalues, double tolerance,
             Threads threads)
      : model_(model),
        threads_(threads),
        n_isovalues_(isovalues.size()),
        selection_(model, isovalues, tolerance) {}

  CrossingSums run(Progress& progress) {
    CrossingSums sums(n_isovalues_);
    CoarseTraversal<D, ManySelection<D>>(selection_, cut_).run();
    std::vector<SharedEdge> shared = add_coarse_leaves(sums);
    const std::vector<BrickWork<D>> work = work_of(cut_);
    std::vector<std::unique_ptr<Worker>> workers(as_size(n_workers(threads_)));
    parallel_for(work.size(), threads_, 1, [&](std::size_t i, int number) {
      if (progress.is_cancelled()) return;
      auto& worker = workers[as_size(number)];
      if (!worker) worker = std::make_unique<Worker>(selection_, n_isovalues_);
      count_brick(*worker, work[i]);
    });
    for (const auto& worker : workers) {
      if (!worker) continue;
      sums.add(worker->counter.sums());
      const auto& some = worker->counter.shared();
      shared.insert(shared.end(), some.begin(), some.end());
    }
    add_shared_edges(shared, sums);
    return sums;
  }

 private:
  struct Worker {
    Worker(const ManySelection<D>& selection, std::size_t n_isovalues)
        : traversal(selection), counter(selection, n_isovalues) {}

    typename LeafCounter<D>::Traversal traversal;
    LeafCounter<D> counter;
  };

  /// Their edges may all be other parts' too.
  std::vector<SharedEdge> add_coarse_leaves(CrossingSums& sums) const {
    std::vector<SharedEdge> edges;
    edges.reserve(cut_.leaves.size() * as_size(D * (D + 1) / 2));
    for (const ActiveSimplex<D>& leaf : cut_.leaves) {
      std::array<std::size_t, as_size(D) + 1> rank;
      for (std::size_t i = 0; i < rank.size(); ++i) rank[i] = selection_.side(leaf.value[i]);
      for (std::size_t i = 0; i < rank.size(); ++i)
        for (std::size_t j = i + 1; j < rank.size(); ++j)
          if (rank[i] != rank[j])
            edges.push_back({to_key(model_.axes.to_grid(leaf.vertex[i])) +
                                 to_key(model_.axes.to_grid(leaf.vertex[j])),
                             static_cast<std::uint32_t>(std::min(rank[i], rank[j])),
                             static_cast<std::uint32_t>(std::max(rank[i], rank[j]))});
      std::sort(rank.begin(), rank.end());
      sums.add_simplex(rank);
    }
    return edges;
  }

  void count_brick(Worker& worker, const BrickWork<D>& work) const {
    const Index<D> brick = point_of<D>(model_.brick_dims, work.brick);
    worker.traversal.open(brick);
    worker.counter.open(worker.traversal, brick);
    TraversalStats stats;
    for (std::size_t s = work.begin; s < work.end; ++s)
      worker.traversal.visit(cut_.brick_simplices[s].second, stats,
                             [&](const BrickSimplex<D>& leaf) { worker.counter.add(leaf); });
  }

  const Model<D>& model_;
  Threads threads_;
  std::size_t n_isovalues_;
  ManySelection<D> selection_;
  CoarseCut<D> cut_;
};

template <int D>
std::vector<CrossingSums::Counts> find_counts(const Model<D>& model, const CountQuery& query,
                                              Progress& progress) {
  const IsovalueList isovalues(query.isovalues);
  if constexpr (D == 3)
    if (query.tolerance == 0 && !model.has_holes()) {
      if (isovalues.size() == 1)
        return {count_full_resolution(model, isovalues[0], query.threads, progress)};
      return count_full_resolution(model, isovalues, query.threads, progress).totals();
    }
  return LeafCounts<D>(model, isovalues, query.tolerance, query.threads).run(progress).totals();
}

}  // namespace

template <int D>
Result<std::vector<SurfaceCounts>> count_isosurfaces(const Model<D>& model, const CountQuery& query,
                                                     Progress& progress) {
  std::vector<SurfaceCounts> result(query.isovalues.size());
  if (!model.shape.has_cells() || query.isovalues.empty()) return result;
  const std::vector<CrossingSums::Counts> counts = find_counts<D>(model, query, progress);
  if (progress.is_cancelled()) return cancelled_error();
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = {static_cast<std::uint64_t>(counts[i].cells),
                 static_cast<std::uint64_t>(counts[i].vertices)};
  return result;
}

template Result<std::vector<SurfaceCounts>> count_isosurfaces<2>(const Model<2>&, const CountQuery&,
                                                                 Progress&);
template Result<std::vector<SurfaceCounts>> count_isosurfaces<3>(const Model<3>&, const CountQuery&,
                                                                 Progress&);

}  // namespace lode::diamond
