#include "lode/models/diamond/query_cut.h"

#include <chrono>

#include "lode/refine/engine.h"

namespace lode::diamond {
namespace {

/// Counts cells while a cut grows.
template <int D>
class CountedRefinable : public Refinable<D> {
 public:
  explicit CountedRefinable(const Refinable<D>& model)
      : Refinable<D>(model), n_cells_(model.n_base_cells()) {}

  std::uint64_t apply(NodeId id) {
    const std::uint64_t n = Refinable<D>::apply(id);
    n_cells_ += n;
    return n;
  }
  [[nodiscard]] std::uint64_t n_cells() const { return n_cells_; }

 private:
  std::uint64_t n_cells_;
};

template <int D>
[[nodiscard]] Result<void> check_count(std::uint64_t n_cells, const CutQuery& query) {
  if (n_cells <= query.most_cells) return {};
  return fail(
      "expected a query whose mesh has at most {} cells, but this one's has more: a larger "
      "tolerance, a focus or a budget of cells makes it smaller",
      query.most_cells);
}

/// The whole demand's cut, found until it is known to be too large.
template <int D>
Result<void> use_one_shot(const Refinable<D>& model, const CutQuery& query, Progress& progress,
                          const auto& use) {
  CountedRefinable<D> counted(model);
  const auto wanted = [&](const NodeFacts& facts) {
    if (counted.n_cells() > query.most_cells || progress.is_cancelled()) return 0.0;
    return query.demand(facts);
  };
  const Cut cut = one_shot(counted, Demand(wanted));
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(check_count<D>(counted.n_cells(), query));
  return use(cut, QueryCutReport{.n_cells = counted.n_cells()});
}

}  // namespace

template <int D>
Result<void> with_cut(const Refinable<D>& model, const CutQuery& query, Progress& progress,
                      const UseCut& use) {
  progress.report("refining", 0);
  if (!query.budget.is_limited()) return use_one_shot<D>(model, query, progress, use);
  Refinable<D> refined(model);
  Engine<Refinable<D>> engine(refined);
  engine.set_query(query.demand, query.budget);
  engine.run([&] { return progress.is_cancelled(); });
  if (progress.is_cancelled()) return cancelled_error();
  const Standing standing = engine.standing();
  LODE_CHECK(check_count<D>(standing.n_cells, query));
  return use(engine.cut(), {.n_cells = standing.n_cells, .budget_met = standing.budget_met});
}

template <int D>
Result<void> with_cut(PagedRefinable<D>& nodes, const CutQuery& query, Progress& progress,
                      const UseCut& use) {
  constexpr int kStepsPerLook = 64;
  constexpr std::chrono::milliseconds kLongestWait{5};
  progress.report("refining", 0);
  // 896,354 tetrahedra as a mesh took 94 MB, the program included.
  constexpr std::uint64_t kBytesPerCell = 100;
  const Budget budget =
      query.cut_bytes > 0 ? query.budget.within(query.cut_bytes, kBytesPerCell) : query.budget;
  Engine<PagedRefinable<D>> engine(nodes);
  engine.set_query(query.demand, budget);
  for (int i = 1; !engine.standing().is_settled; ++i) {
    const bool has_moved = engine.step();
    if (has_moved && i % kStepsPerLook != 0) continue;
    if (progress.is_cancelled()) return cancelled_error();
    LODE_CHECK(check_count<D>(engine.standing().n_cells, query));
    if (has_moved || !engine.standing().awaits_data) continue;
    if (const auto fault = nodes.fault()) return *fault;
    nodes.client().wait(store::Fetcher::Clock::now() + kLongestWait);
  }
  const Standing standing = engine.standing();
  LODE_CHECK(check_count<D>(standing.n_cells, query));
  const bool is_short = standing.budget_ended && budget != query.budget;
  auto used = use(engine.cut(), {.n_cells = standing.n_cells,
                                 .budget_met = standing.n_cells <= query.budget.max_cells,
                                 .memory_met = standing.memory_met && !is_short});
  nodes.let_all_go();
  return used;
}

template Result<void> with_cut<2>(const Refinable<2>&, const CutQuery&, Progress&, const UseCut&);
template Result<void> with_cut<3>(const Refinable<3>&, const CutQuery&, Progress&, const UseCut&);
template Result<void> with_cut<2>(PagedRefinable<2>&, const CutQuery&, Progress&, const UseCut&);
template Result<void> with_cut<3>(PagedRefinable<3>&, const CutQuery&, Progress&, const UseCut&);

}  // namespace lode::diamond
