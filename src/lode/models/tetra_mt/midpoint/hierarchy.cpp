#include "lode/models/tetra_mt/midpoint/hierarchy.h"

#include <algorithm>

namespace lode::tetra_mt::midpoint {

const LeafOffset* ExactLeaves::find(std::uint32_t leaf) const {
  const auto at = std::ranges::lower_bound(leaves_, leaf);
  if (at == leaves_.end() || *at != leaf) return nullptr;
  return &offsets_[static_cast<std::size_t>(at - leaves_.begin())];
}

std::size_t ForestHead::place_of_root(std::uint32_t label) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(roots, label) - roots.begin());
}

Code Hierarchy::code_of(std::uint32_t label) const {
  std::vector<std::uint32_t> path{label};
  for (std::uint32_t at = parent(label); at != kNone; at = parent(at)) path.push_back(at);
  Code code = root_codes[place_of_root(path.back())];
  for (std::size_t i = path.size() - 1; i > 0; --i) {
    const std::uint32_t node = path[i] - n_vertices;
    const Ends ends = parted(code, nodes[node].difference, nodes[node].placement());
    code = path[i - 1] == deep[node] ? ends.first : ends.second;
  }
  return code;
}

std::span<const std::uint32_t> Hierarchy::regions_of(std::uint32_t node) const {
  const auto found = std::ranges::lower_bound(mixed_nodes, node);
  if (found == mixed_nodes.end() || *found != node) return {};
  const auto at = static_cast<std::size_t>(found - mixed_nodes.begin());
  return std::span(mixed_regions)
      .subspan(mixed_begins[at], mixed_begins[at + 1] - mixed_begins[at]);
}

}  // namespace lode::tetra_mt::midpoint
