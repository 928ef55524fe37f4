#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/api/query.h"
#include "lode/api/tetra_dataset.h"
#include "lode/refine/demand.h"

namespace lode {

/// What errors of nodes count where a query's focus is. What is out of sight remains a candidate,
/// and what is out of focus with a tolerance there: neither counts.
class TetraFocus {
 public:
  /// `widening`: as demand_of() takes it; `regions`: numbers that there are.
  TetraFocus(const Query& query, double widening, const TetraInfo& info,
             std::span<const std::int64_t> regions);

  /// Field units; where the query has an opacity, as far as that weighs it.
  [[nodiscard]] double error(const NodeFacts& facts) const;
  /// World units, an estimate, likewise weighed,
  [[nodiscard]] double world_error(const NodeFacts& facts) const;
  /// and how large that appears in the query's view.
  [[nodiscard]] double pixels(const NodeFacts& facts) const;

 private:
  [[nodiscard]] bool counts(const NodeFacts& facts) const {
    return demand_.touches(facts) && (!view_ || view_->shows(facts.bounds));
  }

  /// With a tolerance of 0 a demand is the error, as opacity weighs it, and never quite 0.
  [[nodiscard]] static double weighed(const Demand& demand, const NodeFacts& facts);

  bool is_weighed_;
  std::optional<ViewFocus> view_;
  std::vector<FocusDemand> pixels_;
  Demand demand_;
  Demand world_demand_;  ///< Where errors are weighed, these two of world errors
  Demand pixel_demand_;  ///< and pixels.
};

}  // namespace lode
