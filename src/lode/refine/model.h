#pragma once

// What the engine needs from a multiresolution model. The engine never learns what a node is.

#include <concepts>
#include <cstdint>
#include <vector>

#include "lode/core/box.h"

namespace lode {

/// Minimum and maximum of the full-resolution field; empty (low > high) where there is none.
struct Range {
  double low = 0;
  double high = 0;

  [[nodiscard]] bool is_empty() const { return low > high; }
  [[nodiscard]] bool meets(double value) const { return low <= value && value <= high; }
  [[nodiscard]] bool contains(const Range& r) const {
    return r.is_empty() || (low <= r.low && r.high <= high);
  }
};

/// A node's nested attributes: its own joined with all its descendants'.
struct NodeFacts {
  double error = 0;  ///< Field units: how wrong the field is on its domain if it is not refined.
  Range range;       ///< Of the full-resolution field over the domain.
  Box3d bounds;      ///< World units: contains the domain.
};

/// A model whose refinements are partially ordered. `add_base` appends the nodes that can be
/// applied first; `add_children` those that may follow a node (its discovery children); and
/// `add_parents` those that must be applied before it. Ids are unique and order equal demands.
template <typename M>
concept RefinableModel = requires(const M& model, const typename M::Node& node,
                                  std::vector<typename M::Node>& out) {
  { model.id(node) } -> std::same_as<std::uint64_t>;
  { model.facts(node) } -> std::same_as<NodeFacts>;
  model.add_base(out);
  model.add_children(node, out);
  model.add_parents(node, out);
};

}  // namespace lode
