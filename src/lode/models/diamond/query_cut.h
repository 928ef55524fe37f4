#pragma once

#include <functional>

#include "lode/core/progress.h"
#include "lode/models/diamond/paged_refinable.h"
#include "lode/refine/budget.h"

namespace lode::diamond {

struct CutQuery {
  Demand demand;
  Budget budget{};               ///< Limited: the engine's answer; else the whole demand's.
  std::uint64_t most_cells = 0;  ///< Fails rather than make a cut of more.
  /// Of a file: bytes that the cut and the mesh of it may take, pages aside; 0: any.
  std::uint64_t cut_bytes = 0;
};

struct QueryCutReport {
  std::uint64_t n_cells = 0;  ///< Simplices that may meet the data, before clipping.
  bool budget_met = true;     ///< False: even the base has more cells.
  bool memory_met = true;     ///< False: memory ended it before the demand was met.
};

using UseCut = std::function<Result<void>(const Cut&, const QueryCutReport&)>;

/// Finds the cut of a query and calls use(cut, report); the cut lives no longer than that.
template <int D>
[[nodiscard]] Result<void> with_cut(const Refinable<D>& model, const CutQuery& query,
                                    Progress& progress, const UseCut& use);
/// The same cut from pages of a file, which come as it grows and are held while it lives.
template <int D>
[[nodiscard]] Result<void> with_cut(PagedRefinable<D>& nodes, const CutQuery& query,
                                    Progress& progress, const UseCut& use);

}  // namespace lode::diamond
