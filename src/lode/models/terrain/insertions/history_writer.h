#pragma once

#include <cstdint>
#include <span>

#include "lode/core/height_grid.h"
#include "lode/core/result.h"
#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/models/terrain/insertions/history.h"
#include "lode/models/terrain/insertions/recorder.h"

namespace lode::insertions {

/// Writes down what insertions of a grid's samples do, and what they know of errors.
class HistoryWriter final : public delaunay::InsertionObserver {
 public:
  /// Fails on heights that check_heights() refuses.
  [[nodiscard]] static Result<History> begin(const HeightGrid& grid,
                                             const delaunay::GridDomain& domain, Model model);

  /// The history is what begin() gave, and outlives it.
  explicit HistoryWriter(History& history) : history_(history), recorder_(history) {}

  void on_start(const delaunay::LatticeMesh& mesh) override;
  void on_insertion(const delaunay::LatticeMesh& mesh, std::uint32_t node,
                    std::span<const std::uint32_t> slots, std::size_t n_removed) override;
  /// After all: takes the heights over.
  void finish(const HeightGrid& grid);

 private:
  History& history_;
  Recorder recorder_;
};

}  // namespace lode::insertions
