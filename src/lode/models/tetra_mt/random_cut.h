#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "lode/refine/model.h"

namespace lode::tetra_mt {

/// Applies a node and all that must be before it. Without recursion: chains of parents are long.
template <typename Cut>
void apply_after_parents(NodeId wanted, Cut& cut, std::vector<bool>& is_applied) {
  const auto is_done = [&](NodeId node) { return is_applied[static_cast<std::size_t>(node)]; };
  std::vector<NodeId> waiting{wanted};
  std::vector<NodeId> parents;
  while (!waiting.empty() && !cut.is_damaged()) {
    const NodeId node = waiting.back();
    if (is_done(node)) {
      waiting.pop_back();
      continue;
    }
    parents.clear();
    cut.add_parents(node, parents);
    const std::size_t n_before = waiting.size();
    for (const NodeId parent : parents)
      if (!is_done(parent)) waiting.push_back(parent);
    if (waiting.size() > n_before) continue;
    waiting.pop_back();
    cut.apply(node);
    is_applied[static_cast<std::size_t>(node)] = true;
  }
}

/// Applies some of n nodes at random, and what these need, to a cut at its base: a TetraCut or a
/// MidpointCut.
template <typename Cut>
void apply_at_random(std::uint32_t n_nodes, std::uint32_t n_wanted, std::uint64_t seed, Cut& cut) {
  std::vector<bool> is_applied(n_nodes, false);
  std::mt19937_64 random(seed);
  for (std::uint32_t k = 0; k < n_wanted && n_nodes > 0; ++k)
    apply_after_parents(NodeId{random() % n_nodes}, cut, is_applied);
}

}  // namespace lode::tetra_mt
