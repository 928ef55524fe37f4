#pragma once

#include <concepts>

#include "lode/refine/model.h"

namespace lode {

/// How much a node wants refining: > 0 if at all, the larger the sooner. Must not decrease when
/// the error grows or the range or bounds widen; then it is nested as they are.
template <typename F>
concept Demand = requires(const F& demand, const NodeFacts& facts) {
  { demand(facts) } -> std::convertible_to<double>;
};

/// The same tolerance everywhere, in field units; 0 refines every node, whatever its error.
struct UniformDemand {
  double tolerance = 0;

  [[nodiscard]] double operator()(const NodeFacts& node) const {
    return tolerance == 0 ? 1 + node.error : node.error - tolerance;
  }
};

/// A tolerance where an isosurface may pass, nothing elsewhere.
struct IsovalueDemand {
  double isovalue = 0;
  double tolerance = 0;

  [[nodiscard]] double operator()(const NodeFacts& node) const {
    return node.range.meets(isovalue) ? UniformDemand{tolerance}(node) : 0;
  }
};

}  // namespace lode
