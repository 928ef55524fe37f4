#pragma once

#include <cstdint>
#include <memory>

#include "lode/api/dataset.h"

namespace lode {

/// One step of a surface that is refined until its tolerance is reached.
struct ProgressiveStep {
  double max_error = 0;       ///< The smallest tolerance of the row that it answers, field units.
  double achieved_error = 0;  ///< Proven bound of |F - F'| where the surface may be, <= max_error.
  std::uint64_t new_nodes = 0;  ///< Nodes of the hierarchy refined for it.
  bool is_first = true;         ///< There is nothing it is moved from.
};

/// An isosurface (contour lines of 2D data) from coarse to fine: step k answers the tolerance
/// max(max_error, base error / 2^k), the last the one asked for, 0 after 16 halvings. Steps that
/// change nothing are left out. Each is what Dataset::extract() gives for its tolerance, cells and
/// vertices in another order; and between any two lies a continuous row of surfaces.
class ProgressiveSurface {
 public:
  /// Exactly one isovalue; border, min_component and threads of the options are not used. `dataset`
  /// must outlive it.
  [[nodiscard]] static Result<ProgressiveSurface> begin(const Dataset& dataset,
                                                        const ExtractOptions& options,
                                                        Progress& progress);
  ProgressiveSurface(ProgressiveSurface&&) noexcept;
  ProgressiveSurface& operator=(ProgressiveSurface&&) noexcept;
  ~ProgressiveSurface();

  /// Goes on to the next step, first of all to step 0; false if the one before was the last.
  /// One thread; after an error there is no step.
  [[nodiscard]] Result<bool> advance(Progress& progress);
  /// The step advance() went to.
  [[nodiscard]] const ProgressiveStep& step() const;
  /// How many steps there may be at most.
  [[nodiscard]] int most_steps() const;

  /// The surface on its way from the step before, at 0, to this one, at 1: a manifold at any moment
  /// between, without boundary but at the data's, at holes and the clip box. At 1 it has origins:
  /// where a vertex was at 0, or NaN where the edge it is on was not crossed there. Step 0 has none
  /// and stands still.
  [[nodiscard]] Surface surface(double moment) const;

 private:
  class Impl;
  template <int D>
  class Steps;
  explicit ProgressiveSurface(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace lode
