#pragma once

#include <vector>

#include "lode/refine/cut.h"
#include "lode/refine/demand.h"

namespace lode {

/// Finds the cut of a demand from the base, top-down and without a queue: the ancestors' closure of
/// {demand > 0} as far as discovery reaches. Unique and minimal where the demand is nested.
template <RefinableModel M>
class OneShot {
 public:
  OneShot(M& model, const Demand& demand) : model_(model), demand_(demand) {}

  [[nodiscard]] Cut run() {
    std::vector<NodeId> open;
    model_.add_base(open);
    while (!open.empty()) {
      const NodeId node = open.back();
      open.pop_back();
      const NodeFacts facts = facts_of(model_, node);
      if (!demand_.touches(facts) || !(to_rank(demand_(facts)) > 0)) continue;
      apply(node);
      model_.add_children(node, open);
    }
    return std::move(cut_);
  }

 private:
  /// Applies a node after whatever must come first, iteratively: chains of parents are long.
  void apply(NodeId wanted) {
    std::vector<NodeId> waiting{wanted};
    std::vector<NodeId> parents;
    while (!waiting.empty()) {
      const NodeId node = waiting.back();
      parents.clear();
      model_.add_parents(node, parents);
      const std::size_t n_before = waiting.size();
      for (const NodeId parent : parents)
        if (!cut_.contains(parent)) waiting.push_back(parent);
      if (waiting.size() > n_before) continue;
      waiting.pop_back();
      if (cut_.contains(node)) continue;
      model_.apply(node);
      cut_.set_state(cut_.insert(node, {}), Cut::State::applied);
    }
  }

  M& model_;
  const Demand& demand_;
  Cut cut_;
};

template <RefinableModel M>
[[nodiscard]] Cut one_shot(M& model, const Demand& demand) {
  return OneShot<M>(model, demand).run();
}

}  // namespace lode
