#pragma once

#include <algorithm>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "lode/refine/demand.h"

namespace lode {

/// A consistent set of applied nodes, by id; the rest of the hierarchy is unrefined.
template <typename Node>
class Cut {
 public:
  [[nodiscard]] bool contains(std::uint64_t id) const { return nodes_.contains(id); }
  [[nodiscard]] std::size_t size() const { return nodes_.size(); }
  bool insert(std::uint64_t id, const Node& node) { return nodes_.emplace(id, node).second; }

  /// The applied nodes in the order of their ids.
  [[nodiscard]] std::vector<std::pair<std::uint64_t, Node>> sorted() const {
    std::vector<std::pair<std::uint64_t, Node>> result(nodes_.begin(), nodes_.end());
    std::sort(result.begin(), result.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    return result;
  }

 private:
  std::unordered_map<std::uint64_t, Node> nodes_;
};

/// Finds the cut of a demand from nothing: the ancestors' closure of {demand > 0} as far as
/// discovery from the base reaches. Unique and minimal where the demand is nested.
template <RefinableModel M, Demand F>
class OneShot {
 public:
  using Node = typename M::Node;

  OneShot(const M& model, const F& demand) : model_(model), demand_(demand) {}

  [[nodiscard]] Cut<Node> run() {
    std::vector<Node> open;
    model_.add_base(open);
    while (!open.empty()) {
      const Node node = open.back();
      open.pop_back();
      if (!is_new(node) || !(demand_(model_.facts(node)) > 0)) continue;
      apply(node);
      model_.add_children(node, open);
    }
    return std::move(cut_);
  }

 private:
  bool is_new(const Node& node) { return seen_.insert(model_.id(node), node); }

  /// Applies a node after whatever must come first, iteratively: chains of parents are long.
  void apply(const Node& wanted) {
    std::vector<Node> waiting{wanted};
    std::vector<Node> parents;
    while (!waiting.empty()) {
      const Node node = waiting.back();
      parents.clear();
      model_.add_parents(node, parents);
      const std::size_t n_before = waiting.size();
      for (const Node& parent : parents)
        if (!cut_.contains(model_.id(parent))) waiting.push_back(parent);
      if (waiting.size() > n_before) continue;
      waiting.pop_back();
      cut_.insert(model_.id(node), node);
    }
  }

  const M& model_;
  const F& demand_;
  Cut<Node> cut_;
  Cut<Node> seen_;
};

template <RefinableModel M, Demand F>
[[nodiscard]] Cut<typename M::Node> one_shot(const M& model, const F& demand) {
  return OneShot<M, F>(model, demand).run();
}

}  // namespace lode
