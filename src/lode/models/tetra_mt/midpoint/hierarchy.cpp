#include "lode/models/tetra_mt/midpoint/hierarchy.h"

#include <algorithm>

namespace lode::tetra_mt::midpoint {

std::size_t ForestHead::place_of_root(std::uint32_t label) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(roots, label) - roots.begin());
}

Code Hierarchy::difference(std::uint32_t node, std::size_t field) const {
  Code made = nodes[node].difference;
  if (field > 0) made[3] = further[field - 1].nodes[node].difference;
  return made;
}

Placement Hierarchy::placement(std::uint32_t node, std::size_t field) const {
  Placement made = nodes[node].placement();
  if (field > 0) made.value = further[field - 1].nodes[node].place();
  return made;
}

std::uint32_t Hierarchy::facts(std::uint32_t node, std::size_t field) const {
  const std::uint32_t first = nodes[node].facts;
  return field == 0 ? first
                    : NodeCodes::with_ball_of(further[field - 1].nodes[node].facts(), first);
}

Code Hierarchy::root_code(std::size_t place, std::size_t field) const {
  Code made = root_codes[place];
  if (field > 0) made[3] = further[field - 1].roots.codes[place];
  return made;
}

std::uint32_t Hierarchy::root_word(std::size_t place, std::size_t field) const {
  const std::uint32_t first = root_facts[place];
  return field == 0 ? first : NodeCodes::with_ball_of(further[field - 1].roots.facts[place], first);
}

Code Hierarchy::code_of(std::uint32_t label, std::size_t field) const {
  std::vector<std::uint32_t> path{label};
  for (std::uint32_t at = parent(label); at != kNone; at = parent(at)) path.push_back(at);
  Code code = root_code(place_of_root(path.back()), field);
  for (std::size_t i = path.size() - 1; i > 0; --i) {
    const std::uint32_t node = path[i] - n_vertices;
    const Ends ends = parted(code, difference(node, field), placement(node, field));
    code = path[i - 1] == deep[node] ? ends.first : ends.second;
  }
  return code;
}

Vec3d Hierarchy::position(std::uint32_t label, std::span<const std::int32_t> code) const {
  const LeafOffset* const offset = is_leaf(label) ? exact.find(label) : nullptr;
  const Vec3d coded = scales.position(code);
  return offset != nullptr ? offset->position(coded) : coded;
}

double Hierarchy::value(std::uint32_t label, const Code& code, std::size_t field) const {
  const double coded = fields[field].scale.value(code[3]);
  if (!is_leaf(label)) return coded;
  if (field > 0) {
    const double* const offset = further[field - 1].exact.find(label);
    return offset != nullptr ? with_offset(coded, *offset) : coded;
  }
  const LeafOffset* const offset = exact.find(label);
  return offset != nullptr ? offset->value(coded) : coded;
}

std::span<const std::uint32_t> Hierarchy::regions_of(std::uint32_t node) const {
  const auto found = std::ranges::lower_bound(mixed_nodes, node);
  if (found == mixed_nodes.end() || *found != node) return {};
  const auto at = static_cast<std::size_t>(found - mixed_nodes.begin());
  return std::span(mixed_regions)
      .subspan(mixed_begins[at], mixed_begins[at + 1] - mixed_begins[at]);
}

}  // namespace lode::tetra_mt::midpoint
