#include "lode/models/tetra_mt/random_cut.h"

#include <random>
#include <vector>

namespace lode::tetra_mt {
namespace {

/// Without recursion: chains of parents are long.
void apply_after_parents(NodeId wanted, TetraCut& cut, std::vector<bool>& is_applied) {
  const auto is_done = [&](NodeId node) { return is_applied[static_cast<std::size_t>(node)]; };
  std::vector<NodeId> waiting{wanted};
  std::vector<NodeId> parents;
  while (!waiting.empty() && !cut.is_damaged()) {
    const NodeId node = waiting.back();
    parents.clear();
    cut.add_parents(node, parents);
    const std::size_t n_before = waiting.size();
    for (const NodeId parent : parents)
      if (!is_done(parent)) waiting.push_back(parent);
    if (waiting.size() > n_before) continue;
    waiting.pop_back();
    if (is_done(node)) continue;
    cut.apply(node);
    is_applied[static_cast<std::size_t>(node)] = true;
  }
}

}  // namespace

void apply_at_random(const PackedHierarchy& hierarchy, std::uint32_t n_wanted, std::uint64_t seed,
                     TetraCut& cut) {
  const std::uint32_t n_nodes = hierarchy.head().shape.n_nodes;
  std::vector<bool> is_applied(n_nodes, false);
  std::mt19937_64 random(seed);
  for (std::uint32_t k = 0; k < n_wanted && n_nodes > 0; ++k)
    apply_after_parents(NodeId{random() % n_nodes}, cut, is_applied);
}

}  // namespace lode::tetra_mt
