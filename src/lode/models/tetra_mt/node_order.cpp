#include "lode/models/tetra_mt/node_order.h"

#include <algorithm>

#include "lode/models/tetra_mt/space_curve.h"

namespace lode::tetra_mt {
namespace {

/// Of the node that comes at a place in the order of refinement.
std::uint32_t band_of(std::size_t place, std::size_t n_nodes) {
  constexpr std::size_t kGrowth = 8;
  constexpr std::size_t kSmallest = 1024;
  std::uint32_t band = 0;
  for (std::size_t end = n_nodes; end > kSmallest && place < end / kGrowth; end /= kGrowth) ++band;
  return band;
}

}  // namespace

NodeOrder order_nodes(const TetraMesh& mesh, std::span<const Collapse> collapses) {
  const SpaceCurve curve(mesh.positions);
  std::vector<std::uint8_t> is_base(mesh.positions.size(), 0);
  for (const auto& t : mesh.tetrahedra)
    for (const std::uint32_t v : t) is_base[v] = 1;
  for (const Collapse& c : collapses) is_base[c.removed] = 0;
  struct Keyed {
    std::uint32_t band;
    std::uint64_t key;
    std::uint32_t index;
    auto operator<=>(const Keyed&) const = default;
  };
  std::vector<Keyed> keyed;
  for (std::uint32_t v = 0; v < is_base.size(); ++v)
    if (is_base[v] != 0) keyed.push_back({0, curve(mesh.positions[v]), v});
  std::ranges::sort(keyed);
  NodeOrder order;
  for (const Keyed& k : keyed) order.base_vertices.push_back(k.index);

  keyed.clear();
  const std::size_t n = collapses.size();
  for (std::size_t i = 0; i < n; ++i)
    keyed.push_back({~band_of(n - 1 - i, n), curve(mesh.positions[collapses[i].removed]),
                     static_cast<std::uint32_t>(i)});
  std::ranges::sort(keyed);
  order.nodes.resize(n);
  for (std::uint32_t node = 0; node < n; ++node) order.nodes[keyed[node].index] = node;
  return order;
}

}  // namespace lode::tetra_mt
