#include "lode/models/tetra_mt/midpoint/hierarchy.h"

#include <algorithm>

namespace lode::tetra_mt::midpoint {

void ExactLeaves::add(std::uint32_t leaf, const Vertex& vertex) {
  is_here_[leaf / 64] |= std::uint64_t{1} << leaf % 64;
  leaves_.push_back(leaf);
  vertices_.push_back(vertex);
}

const ExactLeaves::Vertex& ExactLeaves::of(std::uint32_t leaf) const {
  const auto at = std::ranges::lower_bound(leaves_, leaf) - leaves_.begin();
  return vertices_[static_cast<std::size_t>(at)];
}

std::size_t ExactLeaves::n_bytes() const {
  return is_here_.size() * sizeof(std::uint64_t) + leaves_.size() * sizeof(std::uint32_t) +
         vertices_.size() * sizeof(Vertex);
}

Code Hierarchy::code_of(std::uint32_t label) const {
  std::vector<std::uint32_t> path{label};
  for (std::uint32_t at = parent(label); at != kNone; at = parent(at)) path.push_back(at);
  const auto root = std::ranges::lower_bound(roots, path.back()) - roots.begin();
  Code code = root_codes[static_cast<std::size_t>(root)];
  for (std::size_t i = path.size() - 1; i > 0; --i) {
    const std::uint32_t node = path[i] - n_vertices;
    const Ends ends = parted(code, nodes[node].difference, placement(node));
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

std::uint64_t Hierarchy::n_bytes_of_nodes() const {
  return wide.size() * sizeof(std::uint32_t) + deep.size() * sizeof(std::uint32_t) +
         nodes.size() * sizeof(NodeRecord);
}

std::uint64_t Hierarchy::n_bytes_beside() const {
  return base.size() * sizeof(Tetrahedron) + roots.size() * (sizeof(std::uint32_t) + sizeof(Code)) +
         exact.n_bytes() +
         (base_regions.size() + mixed_nodes.size() + mixed_regions.size()) * sizeof(std::uint32_t) +
         mixed_begins.size() * sizeof(std::uint64_t);
}

}  // namespace lode::tetra_mt::midpoint
