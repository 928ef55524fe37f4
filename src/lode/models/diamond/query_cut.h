#pragma once

#include "lode/core/progress.h"
#include "lode/models/diamond/refinable.h"
#include "lode/refine/budget.h"

namespace lode::diamond {

struct CutQuery {
  Demand demand;
  Budget budget{};               ///< Limited: the engine's answer; else the whole demand's.
  std::uint64_t most_cells = 0;  ///< Fails rather than make a cut of more.
};

struct QueryCutReport {
  std::uint64_t n_cells = 0;  ///< Simplices that may meet the data, before clipping.
  bool budget_met = true;     ///< False: even the base has more cells.
};

/// Finds the cut of a query and calls use(cut, report), which returns a Result<void>; the cut lives
/// no longer than that.
template <int D>
[[nodiscard]] Result<void> with_cut(
    const Refinable<D>& model, const CutQuery& query, Progress& progress,
    const std::function<Result<void>(const Cut&, const QueryCutReport&)>& use);

extern template Result<void> with_cut<2>(
    const Refinable<2>&, const CutQuery&, Progress&,
    const std::function<Result<void>(const Cut&, const QueryCutReport&)>&);
extern template Result<void> with_cut<3>(
    const Refinable<3>&, const CutQuery&, Progress&,
    const std::function<Result<void>(const Cut&, const QueryCutReport&)>&);

}  // namespace lode::diamond
